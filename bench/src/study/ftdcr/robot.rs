//! The twin of the robot: what is fitted of it, and what it predicts.
//!
//! Nine tendons at one radius cannot lie in three planes, so each segment's tendons may be turned about the axis. The
//! frame of the tip's marker is found in closed form at every step of the fit.

use std::path::Path;

use anyhow::{Context, Result};
use hysteron_base::{Bounds, Scene};
use hysteron_fem::{Mesh, read_mesh};
use hysteron_twin::fit::{Options, Parameter, Scale, least_squares};
use hysteron_twin::{Error, Stepper, Target, Twin};
use nalgebra::{Matrix3, Rotation3, Vector3};

use super::recording::{N_TENDONS, Pattern, Row};

/// Coordinate error from which on a row counts linearly [m].
const HUBER: f64 = 5e-3;
/// Longest stroke of a step [m].
const STEP: f64 = 2e-3;

/// Scene and mesh.
pub struct Robot {
    scene: Scene,
    mesh: Mesh,
    parameters: Vec<Parameter>,
    /// Rows of the training patterns that a fit uses at most: the twin has no memory, so any rows will do.
    fit_rows: usize,
}

/// Parameters, and the frame of the marker.
pub struct Fitted {
    /// Names of the parameters.
    pub names: Vec<String>,
    /// Their values.
    pub values: Vec<f64>,
    /// Why the search ended.
    pub ended: String,
    turn: Matrix3<f64>,
    shift: Vector3<f64>,
}

/// What the twin says of a row.
#[derive(Debug, Clone)]
pub struct Predicted {
    /// Tip in the frame of the measurement [mm].
    pub tip: [f64; 3],
    /// Direction of the axis at the tip.
    axis: [f64; 3],
    /// Tensions of the nine tendons [N].
    tensions: Vec<f64>,
}

impl Predicted {
    /// Coordinates for a regression: the tip, the direction of the axis there, the tensions.
    pub fn features(&self) -> Vec<f64> {
        [&self.tip[..], &self.axis, &self.tensions].concat()
    }
}

impl Robot {
    /// `meshes/ftdcr-v4`.
    pub fn read(fit_rows: usize) -> Result<Self> {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../meshes/ftdcr-v4");
        let scene = Scene::read(folder.join("scene.toml"))?;
        let mesh = read_mesh(&scene.mesh_path, scene.mesh_unit.to_m())?;
        let parameter = |name: String, start: f64, half: f64| Parameter {
            name,
            start,
            bounds: Bounds { min: start - half, max: start + half },
            scale: Scale::Linear,
        };
        let mut parameters: Vec<Parameter> = scene.tendons[..N_TENDONS]
            .iter()
            .map(|tendon| parameter(format!("zero of {} [m]", tendon.name), 0.0, 5e-3))
            .collect();
        // Evenly staggered: nine tendons around the circle. A turn of all is the frame's.
        for segment in 2..=3 {
            let start = f64::from(segment - 1) * std::f64::consts::TAU / N_TENDONS as f64;
            parameters.push(parameter(format!("turn of segment {segment}'s tendons [rad]"), start, 0.8));
        }
        // Steel rope of some 0.3 mm over half a metre: 0.1 mm/N.
        parameters.push(Parameter {
            name: "compliance of the tendons [m/N]".into(),
            start: 1e-4,
            bounds: Bounds { min: 1e-6, max: 2e-3 },
            scale: Scale::Logarithmic,
        });
        Ok(Self { scene, mesh, parameters, fit_rows })
    }

    fn twin(&self, values: &[f64]) -> hysteron_twin::Result<Twin> {
        let mut scene = self.scene.clone();
        for (k, tendon) in scene.tendons[..N_TENDONS].iter_mut().enumerate() {
            tendon.zero = values[k];
            tendon.compliance = values[N_TENDONS + 2];
            let angle = if k < 3 { 0.0 } else { values[N_TENDONS - 1 + k / 3] };
            let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), angle);
            tendon.points.iter_mut().for_each(|point| *point = (turn * Vector3::from(*point)).into());
        }
        Twin::new(&scene, &self.mesh)
    }

    /// Fits the parameters to the training patterns.
    ///
    /// # Errors
    /// Those of the fit.
    pub fn fit(&self, training: &[Pattern]) -> Result<Fitted> {
        let rows: Vec<&Row> = training.iter().flat_map(|pattern| &pattern.rows).collect();
        let every = rows.len().div_ceil(self.fit_rows);
        let rows: Vec<&Row> = rows.into_iter().step_by(every).collect();
        let measured: Vec<Vector3<f64>> = rows.iter().map(|row| row.tip.into()).collect();
        let options =
            Options { huber: Some(HUBER), smallest_effect: 1e-4, n_nuisance: 6, watch: &|_, _| true };
        let tips = |values: &[f64]| -> hysteron_twin::Result<Vec<Vector3<f64>>> {
            let twin = self.twin(values)?;
            let mut walk = Walk::new(&twin);
            rows.iter().map(|row| Ok(walk.to(row)?.0)).collect()
        };
        let residuals = |values: &[f64]| {
            let tips = tips(values)?;
            let (turn, shift) = alignment(&tips, &measured);
            let error =
                |(tip, to): (&Vector3<f64>, &Vector3<f64>)| (turn * tip + shift - to).as_slice().to_vec();
            Ok(tips.iter().zip(&measured).map(error).collect())
        };
        let fit = least_squares(&self.parameters, &options, residuals)?;
        let (turn, shift) = alignment(&tips(&fit.values())?, &measured);
        let names = fit.estimates.iter().map(|estimate| estimate.name.clone()).collect();
        Ok(Fitted { names, values: fit.values(), ended: fit.ended, turn, shift })
    }

    /// Predictions for all rows, and the number of rows without equilibrium, which keep the state before.
    ///
    /// # Errors
    /// Those of the twin.
    pub fn predict(&self, fitted: &Fitted, patterns: &[Pattern]) -> Result<(Vec<Predicted>, usize)> {
        let twin = self.twin(&fitted.values)?;
        let (mut predicted, mut n_failed) = (Vec::new(), 0);
        for pattern in patterns {
            let mut walk = Walk::new(&twin);
            for row in &pattern.rows {
                let (tip, axis) = match walk.to(row) {
                    Err(Error::NoEquilibrium { .. }) => {
                        n_failed += 1;
                        walk.here()
                    }
                    other => other.with_context(|| pattern.label.clone())?,
                };
                predicted.push(Predicted {
                    tip: (1e3 * (fitted.turn * tip + fitted.shift)).into(),
                    axis: (fitted.turn * axis).into(),
                    tensions: walk.state.tensions[..N_TENDONS].to_vec(),
                });
            }
        }
        Ok((predicted, n_failed))
    }
}

/// From row to row, in steps that are not too long.
struct Walk<'a> {
    twin: &'a Twin,
    stepper: Stepper,
    state: hysteron_twin::TwinState,
    strokes: [f64; N_TENDONS],
}

impl<'a> Walk<'a> {
    fn new(twin: &'a Twin) -> Self {
        Self { twin, stepper: Stepper::new(twin), state: twin.rest(), strokes: [0.0; N_TENDONS] }
    }

    /// Marker and direction of the axis at the tip after going to `row`.
    fn to(&mut self, row: &Row) -> hysteron_twin::Result<(Vector3<f64>, Vector3<f64>)> {
        // Beyond this a tendon is slack however it got there.
        let goal = row.strokes.map(|stroke| stroke.max(-SLACK));
        let from = self.strokes;
        let longest = (0..N_TENDONS).map(|k| (goal[k] - from[k]).abs()).fold(0.0, f64::max);
        let n = (longest / STEP).ceil().max(1.0) as usize;
        for i in 1..=n {
            let part = i as f64 / n as f64;
            let at = |k: usize| Target::Stroke(from[k] + part * (goal[k] - from[k]));
            let mut targets: Vec<Target> = (0..N_TENDONS).map(at).collect();
            targets.push(Target::Stroke(0.0));
            self.stepper.step(self.twin, &targets, &mut self.state)?;
        }
        self.strokes = goal;
        Ok(self.here())
    }

    /// The marker sits beyond the end, on the axis.
    fn here(&self) -> (Vector3<f64>, Vector3<f64>) {
        let line = self.twin.cables.polyline(N_TENDONS, &self.state.positions);
        let [before, end] = [line[line.len() - 2], line[line.len() - 1]].map(Vector3::from);
        let axis = (end - before).normalize();
        (end + MARKER * axis, axis)
    }
}

/// Distance of the marker beyond the end [m], upstream's number.
const MARKER: f64 = 8e-3;
/// Stroke beyond which a released tendon cannot become taut [m]: more than any other pulls.
const SLACK: f64 = 12e-3;

/// Turn and shift that bring `from` nearest to `to` (Kabsch, 1976).
fn alignment(from: &[Vector3<f64>], to: &[Vector3<f64>]) -> (Matrix3<f64>, Vector3<f64>) {
    let mean = |points: &[Vector3<f64>]| points.iter().sum::<Vector3<f64>>() / points.len() as f64;
    let (a, b) = (mean(from), mean(to));
    let moment: Matrix3<f64> = from.iter().zip(to).map(|(p, q)| (q - b) * (p - a).transpose()).sum();
    let svd = moment.svd(true, true);
    let (Some(u), Some(v_t)) = (svd.u, svd.v_t) else { return (Matrix3::identity(), b - a) };
    let mut signs = Vector3::repeat(1.0);
    signs[svd.singular_values.imin()] = (u.determinant() * v_t.determinant()).signum();
    let turn = u * Matrix3::from_diagonal(&signs) * v_t;
    (turn, b - turn * a)
}
