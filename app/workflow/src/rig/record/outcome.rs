//! The outcome of `record`.

use hysteron_actuator::health::Health;
use hysteron_base::Metadata;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::summary::RecordedTrajectory;
use crate::shared::outcome::MetricsFormat;
use crate::shared::shapes::NamedShape;

/// The outcome of `record`: its recordings, and with a report what they show.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Outcome {
    /// Format of the file.
    pub format: MetricsFormat,
    /// Its version.
    pub version: u32,
    /// Samples of all recordings.
    pub samples: usize,
    /// Smallest and largest x, y and z of the tip over all recordings [m].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tip_range_m: Option<[[f64; 2]; 3]>,
    /// One entry per trajectory.
    pub trajectories: Vec<RecordedTrajectory>,
    /// Command and tip over each other, of the recordings that are drawn.
    #[serde(default)]
    pub shapes: Vec<NamedShape>,
    /// Condition of the servos, of a rig that has some.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub health: Option<Health>,
    /// Provenance of the first recording.
    pub source: String,
    /// The command that made the first recording.
    pub command: String,
    /// Commit of the program that made it.
    pub commit: String,
}

impl crate::shared::outcome::Outcome for Outcome {}

impl Outcome {
    /// The trajectories of a session; `meta` is the provenance of the first recording.
    pub fn new(rows: &[RecordedTrajectory], meta: &Metadata) -> Self {
        Self {
            format: MetricsFormat,
            version: 1,
            samples: rows.iter().map(|row| row.rows).sum(),
            tip_range_m: None,
            trajectories: rows.to_vec(),
            shapes: Vec::new(),
            health: None,
            source: meta.source.clone(),
            command: meta.command.clone(),
            commit: meta.commit.clone(),
        }
    }
}
