//! The outcome of `arm identify friction`.

use hysteron_base::checks::Warning;
use hysteron_report::verdict::Verdict;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::shared::identification::{IdentificationFormat, ParameterEstimate};
use crate::shared::outcome;

/// The outcome of `arm identify friction`.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Outcome {
    /// Format of the file.
    pub format: IdentificationFormat,
    /// Its version.
    pub version: u32,
    /// Law of friction.
    pub law: String,
    /// Method of the fit.
    pub method: String,
    /// Number of the joint, from 1.
    pub joint: u16,
    /// The numbers that were found.
    pub estimates: Vec<ParameterEstimate>,
    /// Correlations of the estimates (n_estimates × n_estimates) [-]; none of a population.
    pub correlation: Option<Vec<Vec<f64>>>,
    /// Condition number of the parameters [-]; none of a population.
    pub condition: Option<f64>,
    /// Root mean square error of the torque [N m].
    pub rms_n_m: f64,
    /// The same on the test recordings of each fold [N m]; none without folds.
    pub folds_rms_n_m: Option<Vec<f64>>,
    /// Number of samples.
    pub samples: usize,
    /// Seed of populations.
    pub seed: u64,
    /// Warnings about the fit, as sentences.
    pub warnings: Vec<String>,
    /// Whether the law can be used.
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
