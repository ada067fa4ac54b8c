//! The outcome of `arm identify servo`.

use hysteron_base::checks::Warning;
use hysteron_report::verdict::Verdict;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::shared::identification::{IdentificationFormat, ParameterEstimate};
use crate::shared::outcome;

/// The outcome of `arm identify servo`.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Outcome {
    /// Format of the file.
    pub format: IdentificationFormat,
    /// Its version.
    pub version: u32,
    /// Name of the drive.
    pub drive: String,
    /// Law of friction.
    pub law: String,
    /// The numbers that were found.
    pub estimates: Vec<ParameterEstimate>,
    /// Correlations of the estimates (n_estimates × n_estimates) [-].
    pub correlation: Vec<Vec<f64>>,
    /// Condition number of the parameters [-].
    pub condition: f64,
    /// Mean error of the angle over the recordings, open loop [rad].
    pub error_rad: f64,
    /// The same on recordings that were not fitted [rad]; none without any.
    pub test_error_rad: Option<f64>,
    /// Voltage of the supply [V].
    pub supply_v: f64,
    /// Evaluations of the search.
    pub evaluations: usize,
    /// Whether the search ended at a minimum.
    pub converged: bool,
    /// Whether the drive can be used.
    pub verdict: Verdict,
    /// Warnings about the recordings.
    #[serde(default)]
    pub recording_warnings: Vec<Warning>,
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
