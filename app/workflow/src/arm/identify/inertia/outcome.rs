//! The outcome of `arm identify inertia`.

use hysteron_base::checks::Warning;
use hysteron_report::verdict::Verdict;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::shared::identification::{IdentificationFormat, ParameterEstimate};
use crate::shared::outcome;

/// The outcome of `arm identify inertia`.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Outcome {
    /// Format of the file.
    pub format: IdentificationFormat,
    /// Its version.
    pub version: u32,
    /// Name of the robot.
    pub robot: String,
    /// The numbers that were found.
    pub estimates: Vec<ParameterEstimate>,
    /// Root mean square error of the torque, joint by joint [N m].
    pub rms_n_m: Vec<f64>,
    /// The same on what was not fitted [N m]; none where all was.
    pub test_rms_n_m: Option<Vec<f64>>,
    /// Combinations of parameters that the motion determines.
    pub n_determined: usize,
    /// Condition number of these combinations [-].
    pub condition: f64,
    /// Terms that can hardly be distinguished, as sentences.
    pub warnings: Vec<String>,
    /// Smallest eigenvalue of the pseudo-inertia, body by body; above 0 where a body is physically possible.
    pub least_pseudo_inertias: Vec<f64>,
    /// Number of samples.
    pub samples: usize,
    /// Cut-off frequency of the low pass [Hz].
    pub cutoff_hz: f64,
    /// Response of the measured torques; none where it was not asked for.
    pub response: Option<ResponseEstimate>,
    /// Whether the bodies can be used.
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

/// How measured torques follow those of the rigid arm.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct ResponseEstimate {
    /// Lead of the measured torque, joint by joint [s].
    pub lead_s: Vec<f64>,
    /// Coefficient of its second derivative, joint by joint [s²].
    pub second_s2: Vec<f64>,
    /// Root mean square error of the torque with this response, joint by joint [N m].
    pub rms_n_m: Vec<f64>,
    /// The same on what was not fitted [N m]; none where all was.
    pub test_rms_n_m: Option<Vec<f64>>,
}
