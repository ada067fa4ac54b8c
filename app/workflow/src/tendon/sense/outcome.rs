//! The outcome of `sense`.

use hysteron_base::checks::Warning;
use hysteron_twin::sense::{ForceSensor, SensingScores};
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
