//! The outcome of `arm adapt`: the error before and after.

use std::path::PathBuf;

use hysteron_base::checks::Warning;
use hysteron_report::verdict::Verdict;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::shared::outcome;

/// The outcome of `arm adapt`.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Outcome {
    /// Mean absolute error of the joints in pure simulation of the recordings by the actuator as it was [deg].
    pub before_deg: f64,
    /// The same by the adapted actuator [deg].
    pub after_deg: f64,
    /// File of the adapted actuator.
    pub actuator: PathBuf,
    /// Whether the adapted actuator can be used.
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
