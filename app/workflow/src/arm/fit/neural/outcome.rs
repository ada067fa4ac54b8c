//! The outcome of `arm fit neural`.

use std::path::PathBuf;

use hysteron_base::checks::Warning;
use hysteron_report::verdict::Verdict;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::shared::outcome;

/// The outcome of `arm fit neural`.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Outcome {
    /// Root mean square error of the joints in rollouts of the validation trajectories [deg].
    pub validation_deg: f64,
    /// Epochs done when the weights in the loop were found.
    pub epochs: usize,
    /// Parameters of the network in the loop.
    pub parameters: usize,
    /// Steps simulated per second of training [1/s].
    pub steps_per_second: f64,
    /// Loss of force, contact and condition in validation; none without a network of their own.
    pub sensing_validation: Option<f64>,
    /// File of the actuator.
    pub actuator: PathBuf,
    /// Whether the actuator can be used.
    pub verdict: Verdict,
    /// Warnings about the recordings.
    #[serde(default)]
    pub recording_warnings: Vec<Warning>,
    /// Joints that `--fix-base` holds at zero.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub held_joints: Vec<String>,
}

impl outcome::Outcome for Outcome {
    fn verdict(&self) -> Option<&Verdict> {
        Some(&self.verdict)
    }
}
