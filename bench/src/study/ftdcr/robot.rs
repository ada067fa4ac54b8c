//! The finite-element twin of the robot with the parameters of the reduced model.

use std::path::Path;

use anyhow::{Context, Result};
use hysteron_base::Scene;
use hysteron_fem::{Mesh, read_mesh};
use hysteron_twin::{Error, Stepper, Target, Twin, TwinState};
use nalgebra::{Rotation3, Vector3};

use super::fit::Fitted;
use super::recording::{N_TENDONS, Row};
use super::reduced::{MARKER, Reduced};

/// Cables behind the tendons that hold the length of each segment.
const N_AXIS: usize = 3;
/// Longest stroke of a step [m].
const STEP: f64 = 0.2e-3;
/// Stroke beyond which a released tendon cannot become taut [m]: more than any other pulls.
const SLACK: f64 = 12e-3;

/// Scene and mesh.
pub struct Robot {
    scene: Scene,
    mesh: Mesh,
}

impl Robot {
    /// `meshes/ftdcr-v4`.
    pub fn read() -> Result<Self> {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../meshes/ftdcr-v4");
        let scene = Scene::read(folder.join("scene.toml"))?;
        let mesh = read_mesh(&scene.mesh_path, scene.mesh_unit.to_m())?;
        Ok(Self { scene, mesh })
    }

    fn twin(&self, model: &Reduced) -> Result<Twin> {
        let mut scene = self.scene.clone();
        for (k, tendon) in scene.tendons[..N_TENDONS].iter_mut().enumerate() {
            tendon.zero = model.zeros[k];
            tendon.compliance = model.compliance;
            let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), model.turns[k / 3]);
            tendon.points.iter_mut().for_each(|point| *point = (turn * Vector3::from(*point)).into());
        }
        Ok(Twin::new(&scene, &self.mesh)?)
    }

    /// Tips [mm] in these rows of patterns, each pattern from rest, and the number of rows without equilibrium, which keep the shape before.
    ///
    /// # Errors
    /// Those of the twin.
    pub fn predict(&self, fitted: &Fitted, patterns: &[Vec<&Row>]) -> Result<(Vec<[f64; 3]>, usize)> {
        let twin = self.twin(&fitted.model)?;
        let (mut tips, mut n_failed) = (Vec::new(), 0);
        for rows in patterns {
            let mut walk = Walk::new(&twin);
            for row in rows {
                match walk.to(row) {
                    Err(Error::NoEquilibrium { .. }) => n_failed += 1,
                    other => other.context("a step of the twin")?,
                }
                tips.push(fitted.measured(walk.marker()));
            }
        }
        Ok((tips, n_failed))
    }
}

/// From row to row, in steps that are not too long.
struct Walk<'a> {
    twin: &'a Twin,
    stepper: Stepper,
    state: TwinState,
    strokes: [f64; N_TENDONS],
}

impl<'a> Walk<'a> {
    fn new(twin: &'a Twin) -> Self {
        Self { twin, stepper: Stepper::new(twin), state: twin.rest(), strokes: [0.0; N_TENDONS] }
    }

    fn to(&mut self, row: &Row) -> hysteron_twin::Result<()> {
        // Beyond this a tendon is slack however it got there.
        let goal = row.strokes.map(|stroke| stroke.max(-SLACK));
        let from = self.strokes;
        let longest = (0..N_TENDONS).map(|k| (goal[k] - from[k]).abs()).fold(0.0, f64::max);
        let n = (longest / STEP).ceil().max(1.0) as usize;
        for i in 1..=n {
            let part = i as f64 / n as f64;
            let at = |k: usize| Target::Stroke(from[k] + part * (goal[k] - from[k]));
            let mut targets: Vec<Target> = (0..N_TENDONS).map(at).collect();
            targets.extend([Target::Stroke(0.0); N_AXIS]);
            self.stepper.step(self.twin, &targets, &mut self.state)?;
        }
        self.strokes = goal;
        Ok(())
    }

    /// The marker sits beyond the end, on the axis.
    fn marker(&self) -> Vector3<f64> {
        let line = self.twin.cables.polyline(N_TENDONS + N_AXIS - 1, &self.state.positions);
        let [before, end] = [line[line.len() - 2], line[line.len() - 1]].map(Vector3::from);
        end + MARKER * (end - before).normalize()
    }
}
