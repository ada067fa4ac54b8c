//! The outcome of `check`.

use std::path::PathBuf;

use hysteron_base::checks::Warning;
use hysteron_twin::LockingEstimate;
use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize};

use crate::shared::outcome;
use crate::tendon::mesh::MeshSummary;

/// The outcome of `check`: of a scene alone, or of recordings, with the scene that they are compared with.
#[derive(Debug, Clone, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum Outcome {
    /// Of recordings.
    Recordings(RecordingFindings),
    /// Of a scene.
    Scene(SceneSummary),
}

impl outcome::Outcome for Outcome {}

impl<'de> Deserialize<'de> for Outcome {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        outcome::by_key(deserializer, "findings", Self::Recordings, Self::Scene)
    }
}

/// A scene in numbers.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct SceneSummary {
    /// Name of the robot.
    pub robot: String,
    /// SHA-256 of the scene.
    pub scene_sha256: String,
    /// The mesh.
    pub mesh: MeshSummary,
    /// Mass of the body [kg].
    pub mass_kg: f64,
    /// Tip of the unloaded body [m].
    pub tip_m: [f64; 3],
    /// Tendons of the robot.
    pub tendons: usize,
    /// Auxiliary tendons, which correct the twin.
    pub auxiliary_tendons: usize,
    /// Degrees of freedom.
    pub unknowns: usize,
    /// Memory that the factor of the stiffness takes [byte].
    pub factor_bytes: usize,
    /// Share of the motion that linear tetrahedra lose.
    pub locking: LockingEstimate,
    /// Warnings about the mesh, as sentences.
    pub warnings: Vec<String>,
}

/// Recordings, and what was found in them.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct RecordingFindings {
    /// One for each recording.
    pub recordings: Vec<Described>,
    /// Files that could not be read, and why.
    pub unreadable: Vec<[String; 2]>,
    /// Number of warnings.
    pub warnings: usize,
    /// Number of findings that cannot be right, unreadable files included.
    pub errors: usize,
    /// All findings.
    pub findings: Vec<Warning>,
    /// The scene that the recordings were compared with.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scene: Option<SceneSummary>,
}

/// Size of a recording.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Described {
    /// Name of the file without its ending.
    pub name: String,
    /// The file.
    pub path: PathBuf,
    /// Number of samples.
    pub samples: usize,
    /// Time from the first to the last sample [s].
    pub duration_s: f64,
    /// Rate [Hz]; none where steps are uneven.
    pub rate_hz: Option<f64>,
    /// Number of channels.
    pub channels: usize,
}
