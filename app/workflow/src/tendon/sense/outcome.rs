//! The outcome of `sense`.

use std::borrow::Cow;

use hysteron_base::checks::Warning;
use hysteron_twin::sense::ForceSensor;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::shared::inputs::Input;
use crate::shared::outcome::MetricsFormat;
use crate::shared::recording_checks::Findings;
use crate::{COMMIT, Context};

/// The outcome of `sense`.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Outcome {
    /// Format of the file.
    pub format: MetricsFormat,
    /// Its version.
    pub version: u32,
    /// How good the estimates are, where the truth is known.
    pub scores: SensingScores,
    /// The sensor that made the estimates.
    pub sensor: ForceSensor,
    /// Warnings about the recording.
    #[serde(default)]
    pub recording_warnings: Vec<Warning>,
    /// Name of the recording.
    pub recording: String,
    /// SHA-256 of its file.
    pub recording_sha256: String,
    /// The command that made this.
    pub command: String,
    /// Commit of the program.
    pub commit: String,
}

impl crate::shared::outcome::Outcome for Outcome {}

impl Outcome {
    pub(super) fn new(
        scores: SensingScores,
        sensor: ForceSensor,
        input: &Input,
        findings: &Findings,
        context: &Context,
    ) -> Self {
        Self {
            format: MetricsFormat,
            version: 1,
            scores,
            sensor,
            recording_warnings: findings.warnings().to_vec(),
            recording: input.name.clone(),
            recording_sha256: input.hash.clone(),
            command: context.command.clone(),
            commit: COMMIT.to_owned(),
        }
    }
}

/// Errors of tensions over their root mean square [-].
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct TensionScore {
    /// Method of the estimate.
    pub method: Cow<'static, str>,
    /// All samples.
    pub all: f64,
    /// While the tendons move.
    pub moving: f64,
    /// While they rest.
    pub resting: f64,
}

/// Errors of the force on the tip.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct ForceScore {
    /// Method of the estimate.
    pub method: Cow<'static, str>,
    /// Which samples.
    pub samples: Cow<'static, str>,
    /// How many.
    pub n: usize,
    /// Root mean square of the error's norm [N].
    pub rms_n: f64,
    /// Median of the error's norm [N].
    pub median_n: f64,
    /// Share within 30 mN or 15 % [-].
    pub near: f64,
    /// Share whose direction is off by 15° at most [-].
    pub aligned: f64,
}

/// How contacts were found.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct ContactScore {
    /// Contacts.
    pub contacts: usize,
    /// Share found within 100 ms [-], of all and of those that were not preceded by a contact that had not been given up.
    pub found_at_once: f64,
    /// Share of contacts above 0.15 N found within 100 ms [-].
    pub strong_found_at_once: f64,
    /// Alarms while there was no contact and had been none for a second, an hour [1/h].
    pub false_alarms_per_hour: f64,
    /// Time without contact [s].
    pub free_s: f64,
    /// Share of it in which a contact was claimed [-].
    pub claimed: f64,
}

/// Scores of all estimates.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct SensingScores {
    /// Where tensions are known.
    pub tensions: Vec<TensionScore>,
    /// Samples with a known force during pushes.
    pub forces: Vec<ForceScore>,
    /// See `forces`; samples without pushes too.
    pub contacts: Option<ContactScore>,
}
