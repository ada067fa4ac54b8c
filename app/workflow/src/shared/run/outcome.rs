//! The outcome of a run, and the data that its figures show.

use hysteron_base::{Recording, Scene};
use hysteron_twin::command::Goals;
use hysteron_twin::{Twin, TwinState};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::input::Task;
use super::summary::RunSummary;
use crate::shared::outcome::MetricsFormat;
use crate::shared::shapes::NamedShape;

/// The outcome of `simulate` and of `reach`.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Outcome {
    /// Format of the file.
    pub format: MetricsFormat,
    /// Its version.
    pub version: u32,
    /// The robot and the size of its model.
    pub robot: RobotSize,
    /// The numbers of the run.
    pub run: RunSummary,
    /// Command and tip over each other, where the tendons bend in two directions.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub shapes: Vec<NamedShape>,
    /// Samples simulated per second of computing time [1/s].
    pub steps_per_s: f64,
    /// Corrections with the lagged factor per sample [-].
    pub iterations_per_step: f64,
    /// Provenance of the strokes or goals.
    pub source: String,
    /// The command that made this.
    pub command: String,
    /// Commit of the program.
    pub commit: String,
}

/// Size of a robot's model.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct RobotSize {
    /// Name of the robot.
    pub name: String,
    /// SHA-256 of its scene.
    pub scene_sha256: String,
    /// Nodes of its mesh.
    pub nodes: usize,
    /// Tetrahedra of its mesh.
    pub tetrahedra: usize,
    /// Degrees of freedom.
    pub unknowns: usize,
    /// Tendons of the robot.
    pub tendons: usize,
    /// Auxiliary tendons, which correct the twin.
    pub auxiliary_tendons: usize,
    /// The chain that moves in place of the mesh, if there is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub chain: Option<ChainSize>,
}

/// Size of a chain of condensed sections.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct ChainSize {
    /// Sections.
    pub sections: usize,
    /// Degrees of freedom.
    pub unknowns: usize,
}

impl crate::shared::outcome::Outcome for Outcome {}

impl Outcome {
    /// The outcome of a run.
    pub(super) fn new(run: &Run, shapes: Vec<NamedShape>) -> Self {
        let meta = run.recording.meta();
        let summary = run.summary;
        Self {
            format: MetricsFormat,
            version: 1,
            robot: RobotSize {
                name: run.scene.name.clone(),
                scene_sha256: run.scene.hash.clone(),
                nodes: run.twin.body.n_nodes(),
                tetrahedra: run.twin.body.cells.len(),
                unknowns: run.twin.body.n_unknowns(),
                tendons: run.twin.n_primary,
                auxiliary_tendons: run.twin.tendons.len() - run.twin.n_primary,
                chain: run
                    .twin
                    .chain
                    .as_ref()
                    .map(|chain| ChainSize { sections: chain.n_sections(), unknowns: chain.n_unknowns() }),
            },
            run: summary.clone(),
            shapes,
            steps_per_s: summary.rate(),
            iterations_per_step: summary.iterations as f64 / summary.steps.max(1) as f64,
            source: meta.source.clone(),
            command: meta.command.clone(),
            commit: meta.commit.clone(),
        }
    }
}

/// Everything a figure or report may show.
pub struct Run<'a> {
    /// Task of the run.
    pub task: Task,
    /// The robot.
    pub twin: &'a Twin,
    /// The scene it was made from.
    pub scene: &'a Scene,
    /// Recording of the run.
    pub recording: &'a Recording,
    /// Where the tip was to go, if that was asked.
    pub goals: Option<&'a Goals<'a>>,
    /// Where the robot's own tip was measured under the same strokes, if it was: x, y and z (n_samples each) [m].
    pub measured: Option<[&'a [f64]; 3]>,
    /// Samples whose tip was not measured (n_samples).
    pub gap: &'a [bool],
    /// State in which the tip was farthest from rest, and its sample.
    pub farthest: (usize, &'a TwinState),
    /// Numbers of the run.
    pub summary: &'a RunSummary,
}
