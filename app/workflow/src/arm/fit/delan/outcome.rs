//! The outcome of `arm fit delan`.

use std::path::PathBuf;

use hysteron_base::checks::Warning;
use hysteron_report::verdict::Verdict;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::shared::outcome;

/// The outcome of `arm fit delan`.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Outcome {
    /// Error in validation over the deviation of the torques [-].
    pub validation: f64,
    /// Epochs of Adam.
    pub epochs: usize,
    /// Steps of Levenberg and Marquardt's method.
    pub steps: usize,
    /// File of the model.
    pub model: PathBuf,
    /// Whether the model can be used.
    pub verdict: Verdict,
    /// Warnings about the recordings.
    #[serde(default)]
    pub recording_warnings: Vec<Warning>,
}

impl outcome::Outcome for Outcome {
    fn verdict(&self) -> Option<&Verdict> {
        Some(&self.verdict)
    }
}
