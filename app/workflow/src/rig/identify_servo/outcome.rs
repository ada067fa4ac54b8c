//! The outcome of `identify-servo`.

use hysteron_base::checks::Warning;
use hysteron_report::verdict::Verdict;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::shared::identification::{IdentificationFormat, ParameterEstimate};
use crate::shared::outcome;

/// The outcome of `identify-servo`.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Outcome {
    /// Format of the file.
    pub format: IdentificationFormat,
    /// Its version.
    pub version: u32,
    /// Law of friction.
    pub law: String,
    /// Speed below which no motion counts as steady [rad/s].
    pub slowest_rad_s: f64,
    /// Time from one sample to the next [s].
    pub period_s: f64,
    /// Name and SHA-256 of every recording.
    pub recordings: Vec<[String; 2]>,
    /// One entry per servo.
    pub servos: Vec<ServoEstimates>,
    /// Whether the numbers can be used.
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

/// A servo.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct ServoEstimates {
    /// Its number, from 1.
    pub servo: usize,
    /// Radius of its pulley [mm].
    pub radius_mm: f64,
    /// Whether tensions were measured.
    pub has_tension: bool,
    /// The numbers that were found.
    pub estimates: Vec<ParameterEstimate>,
    /// Samples of steady motion.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub samples: Option<usize>,
    /// Root mean square error of the friction [N m].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rms_n_m: Option<f64>,
    /// Misfit of the law, 1 for none [-].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub misfit: Option<f64>,
    /// Condition number of the parameters [-].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub condition: Option<f64>,
    /// Why friction cannot be identified.
    #[serde(rename = "cannot_be_told", default, skip_serializing_if = "Option::is_none")]
    pub failure: Option<String>,
    /// Width of the gap at every reversal [mm].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reversals_mm: Option<Vec<f64>>,
}
