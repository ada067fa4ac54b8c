//! The outcome of `arm identify payload`.

use hysteron_base::checks::Warning;
use hysteron_report::verdict::Verdict;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::shared::identification::{IdentificationFormat, ParameterEstimate};
use crate::shared::outcome;

/// The outcome of `arm identify payload`.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Outcome {
    /// Format of the file.
    pub format: IdentificationFormat,
    /// Its version.
    pub version: u32,
    /// Name of the robot.
    pub robot: String,
    /// Frame that holds the payload.
    pub frame: String,
    /// The numbers that were found.
    pub estimates: Vec<ParameterEstimate>,
    /// Root mean square error of the torque of the loaded arm without the payload, joint by joint [N m].
    pub rms_without_n_m: Vec<f64>,
    /// The same with the payload [N m].
    pub rms_with_n_m: Vec<f64>,
    /// The same of the bare arm [N m].
    pub rms_bare_n_m: Vec<f64>,
    /// Samples with the payload.
    pub samples: usize,
    /// Cut-off frequency of the low pass [Hz].
    pub cutoff_hz: f64,
    /// Whether the payload can be used.
    pub verdict: Verdict,
    /// Warnings about the recordings.
    #[serde(default)]
    pub recording_warnings: Vec<Warning>,
    /// Joints that `--fix-base` holds at zero.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub held_joints: Vec<String>,
    /// The command that made this.
    pub command: String,
    /// Commit of the program.
    pub commit: String,
}

impl outcome::Outcome for Outcome {
    fn verdict(&self) -> Option<&Verdict> {
        Some(&self.verdict)
    }
}
