//! The outcome of `fit-residual`.

use hysteron_base::checks::Warning;
use hysteron_learn::FitReport;
use hysteron_report::verdict::Verdict;
use hysteron_twin::residual::ResidualTraining;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::shared::outcome::MetricsFormat;
use crate::shared::recording_checks::Findings;
use crate::shared::training;
use crate::{COMMIT, Context};

/// The outcome of `fit-residual`.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Outcome {
    /// Format of the file.
    pub format: MetricsFormat,
    /// Its version.
    pub version: u32,
    /// Whether the networks can be used.
    pub verdict: Verdict,
    /// Learning curve, and errors in validation next to those of the baselines: one entry per network.
    pub networks: Vec<FitReport>,
    /// Where a network does no better than a baseline.
    pub warnings: Vec<String>,
    /// Warnings about the recordings.
    #[serde(default)]
    pub recording_warnings: Vec<Warning>,
    /// Data and options, as the checkpoint holds them.
    pub training: ResidualTraining,
    /// The command that made this.
    pub command: String,
    /// Commit of the program.
    pub commit: String,
}

impl crate::shared::outcome::Outcome for Outcome {
    fn verdict(&self) -> Option<&Verdict> {
        Some(&self.verdict)
    }
}

impl Outcome {
    pub(super) fn new(
        networks: Vec<FitReport>,
        described: ResidualTraining,
        findings: &Findings,
        context: &Context,
    ) -> Self {
        Self {
            format: MetricsFormat,
            version: 1,
            verdict: training::verdict(&networks),
            warnings: training::losses(&networks),
            networks,
            recording_warnings: findings.warnings().to_vec(),
            training: described,
            command: context.command.clone(),
            commit: COMMIT.to_owned(),
        }
    }
}
