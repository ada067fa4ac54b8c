//! The finite-element twin of the robot, with the parameters of the reduced model or its own.

use std::path::Path;

use anyhow::{Context, Result};
use hysteron_base::Scene;
use hysteron_fem::{Mesh, read_mesh};
use hysteron_twin::coreact::{AuxiliaryLimits, AuxiliaryPolicy, Identifier, IdentifyOptions, TipMeasurement};
use hysteron_twin::{Error, Stepper, Target, Twin, TwinState};
use nalgebra::{Rotation3, Vector3};

use super::fit::Fitted;
use super::recording::{N_TENDONS, Pattern, Row};
use super::reduced::Reduced;

/// Cables behind the tendons that hold the length of each segment.
const N_AXIS: usize = 3;
/// Cross-section of the solid [m²]: 17 656.1 mm³ over 186.5 mm (`meshes/ftdcr-v4`).
const AREA: f64 = 17656.1e-9 / 186.5e-3;
/// Longest stroke of a step [m].
const STEP: f64 = 0.3e-3;
/// Stroke beyond which a released tendon cannot become taut [m]: more than any other pulls.
const SLACK: f64 = 12e-3;
/// Duration of a step with auxiliary tendons [s]; the recording's rows are 0.58 s apart.
const DURATION: f64 = 0.1;
/// Rounds in which auxiliary tendons bring the marker to its place, each by the twin linearised where it is.
const ROUNDS: usize = 6;

/// Of the real tendons and of those along the axis [m].
type TendonStrokes = [f64; N_TENDONS + N_AXIS];

/// Scene and mesh.
pub struct Robot {
    scene: Scene,
    mesh: Mesh,
}

impl Robot {
    /// `meshes/ftdcr-v4` below the root of a checkout of the project.
    ///
    /// # Errors
    /// The files cannot be read.
    pub fn read(repository: &Path) -> Result<Self> {
        let folder = repository.join("meshes/ftdcr-v4");
        let scene = Scene::read(folder.join("scene.toml"))?;
        let mesh = read_mesh(&scene.mesh_path, scene.mesh_unit.to_m())?;
        Ok(Self { scene, mesh })
    }

    /// The twin with the parameters of the reduced model, without auxiliary tendons.
    fn twin(&self, model: &Reduced) -> Result<Twin> {
        let mut scene = self.scene(model);
        scene.auxiliary = None;
        Ok(Twin::new(&scene, &self.mesh)?)
    }

    fn scene(&self, model: &Reduced) -> Scene {
        let mut scene = self.scene.clone();
        // Any density will do: the acceleration makes the weight of it.
        scene.material.density = 1e3;
        scene.gravity = (model.weight / (scene.material.density * AREA)).into();
        for (k, tendon) in scene.tendons[..N_TENDONS].iter_mut().enumerate() {
            tendon.zero = model.zeros[k];
            tendon.compliance = model.compliance;
            let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), model.turns[k / 3]);
            tendon.points.iter_mut().for_each(|point| *point = (turn * Vector3::from(*point)).into());
        }
        scene
    }

    /// The parameters with which the twin itself comes nearest to every `every`-th row of the patterns: the reduced
    /// model moves them, the difference of the two models stays what it was with the reduced model's own.
    ///
    /// # Errors
    /// Those of the twin and of the fit.
    pub fn fit(&self, reduced: &Fitted, training: &[Pattern], every: usize) -> Result<Fitted> {
        let twin = self.twin(&reduced.model)?;
        let (mut rows, mut further) = (Vec::new(), Vec::new());
        for pattern in training {
            let mut stepper = TwinSteps::new(&twin, &reduced.model);
            for row in pattern.rows.iter().step_by(every) {
                if stepper.reaches(row)? {
                    rows.push(row);
                    further.push(stepper.marker() - reduced.model.shape(row).marker);
                }
            }
        }
        reduced.again(&rows, &further)
    }

    /// Markers [m] in these rows of patterns, each pattern from rest, and the number of rows without equilibrium,
    /// which keep the shape before.
    ///
    /// # Errors
    /// Those of the twin.
    pub fn predict(&self, fitted: &Fitted, patterns: &[Vec<&Row>]) -> Result<(Vec<Vector3<f64>>, usize)> {
        let twin = self.twin(&fitted.model)?;
        let (mut markers, mut n_failed) = (Vec::new(), 0);
        for rows in patterns {
            let mut stepper = TwinSteps::new(&twin, &fitted.model);
            for row in rows {
                n_failed += usize::from(!stepper.reaches(row)?);
                markers.push(stepper.marker());
            }
        }
        Ok((markers, n_failed))
    }

    /// Markers [m] in the same rows where auxiliary tendons bring them towards `desired` [m], one for each row; and
    /// the number of rows that were not reached, which keep the shape before.
    ///
    /// # Errors
    /// Those of the twin.
    pub fn lead(
        &self,
        fitted: &Fitted,
        patterns: &[Vec<&Row>],
        desired: &[Vector3<f64>],
    ) -> Result<(Vec<Vector3<f64>>, usize)> {
        let twin = Twin::new(&self.scene(&fitted.model), &self.mesh)?;
        let auxiliary = AuxiliaryLimits::new(&twin)?;
        let (mut markers, mut n_failed, mut goals) = (Vec::new(), 0, desired.iter());
        for rows in patterns {
            let mut led = Led::new(&twin, &auxiliary, &fitted.model);
            for (row, goal) in rows.iter().zip(&mut goals) {
                n_failed += usize::from(!led.reaches(row, goal)?);
                markers.push(marker(&twin, led.identifier.state(), fitted.model.marker));
            }
        }
        Ok((markers, n_failed))
    }
}

/// Targets of the real tendons and of those along the axis as strokes [m]: a tendon released beyond `SLACK` is slack
/// however it got there.
fn primary(model: &Reduced, row: &Row) -> TendonStrokes {
    let strokes = model.strokes_at_body(row);
    std::array::from_fn(|k| strokes.get(k).map_or(0.0, |stroke| stroke.max(-SLACK)))
}

/// Strokes on the way from one row to the next, the last included, none longer than `STEP`.
fn between(from: TendonStrokes, to: TendonStrokes) -> impl Iterator<Item = TendonStrokes> {
    let longest = from.iter().zip(&to).map(|(a, b)| (b - a).abs()).fold(0.0, f64::max);
    let n = (longest / STEP).ceil().max(1.0) as usize;
    (1..=n).map(move |i| std::array::from_fn(|k| from[k] + i as f64 / n as f64 * (to[k] - from[k])))
}

/// Steps from these strokes to those of a row, none too long; true if there is an equilibrium on all of the way.
fn step_to(
    strokes: &mut TendonStrokes,
    to: TendonStrokes,
    mut step: impl FnMut(&TendonStrokes) -> Result<bool>,
) -> Result<bool> {
    for next in between(*strokes, to) {
        if !step(&next)? {
            return Ok(false);
        }
        *strokes = next;
    }
    Ok(true)
}

/// Whether a step found an equilibrium.
fn is_balanced<T>(step: hysteron_twin::Result<T>) -> Result<bool> {
    match step {
        Err(Error::NoEquilibrium { .. }) => Ok(false),
        other => other.map(|_| true).context("a step of the twin"),
    }
}

/// From row to row, under the real tendons alone.
struct TwinSteps<'a> {
    twin: &'a Twin,
    model: &'a Reduced,
    stepper: Stepper,
    strokes: TendonStrokes,
}

impl<'a> TwinSteps<'a> {
    fn new(twin: &'a Twin, model: &'a Reduced) -> Self {
        Self { twin, model, stepper: Stepper::new(twin), strokes: [0.0; N_TENDONS + N_AXIS] }
    }

    /// True if there is an equilibrium; the shape stays at the last one.
    fn reaches(&mut self, row: &Row) -> Result<bool> {
        step_to(&mut self.strokes, primary(self.model, row), |strokes| {
            let targets = strokes.map(Target::Stroke);
            is_balanced(self.stepper.step(self.twin, &targets))
        })
    }

    fn marker(&self) -> Vector3<f64> {
        marker(self.twin, self.stepper.state(), self.model.marker)
    }
}

/// The marker sits so far beyond the end [m], on the axis.
fn marker(twin: &Twin, state: &TwinState, beyond: f64) -> Vector3<f64> {
    let line = twin.cables.polyline(N_TENDONS + N_AXIS - 1, &state.positions);
    let [before, end] = [line[line.len() - 2], line[line.len() - 1]].map(Vector3::from);
    end + beyond * (end - before).normalize()
}

/// From row to row with auxiliary tendons, which bring the marker to where it shall be.
struct Led<'a> {
    twin: &'a Twin,
    model: &'a Reduced,
    identifier: Identifier<'a>,
    strokes: TendonStrokes,
}

impl<'a> Led<'a> {
    fn new(twin: &'a Twin, auxiliary: &'a AuxiliaryLimits, model: &'a Reduced) -> Self {
        let options = IdentifyOptions { rounds: 1, ..IdentifyOptions::default() };
        let identifier = Identifier::new(twin, auxiliary, options);
        Self { twin, model, identifier, strokes: [0.0; N_TENDONS + N_AXIS] }
    }

    /// True if there is an equilibrium on all of the way.
    fn reaches(&mut self, row: &Row, desired: &Vector3<f64>) -> Result<bool> {
        let identifier = &mut self.identifier;
        let to = primary(self.model, row);
        if !step_to(&mut self.strokes, to, |strokes| is_balanced(identifier.step(strokes, None, DURATION)))? {
            return Ok(false);
        }
        for _ in 0..ROUNDS {
            // The twin is led by its tip; the marker is beyond it.
            let state = identifier.state();
            let missing = desired - marker(self.twin, state, self.model.marker);
            let position = (Vector3::from(self.twin.tip_of(state)) + missing).into();
            let goal = TipMeasurement { position, orientation: None };
            if !is_balanced(identifier.step(&to, Some(&goal), DURATION))? {
                return Ok(false);
            }
        }
        Ok(true)
    }
}
