//! The outcome of `train`.

use hysteron_base::checks::Warning;
use hysteron_control::inverse::{Dataset, FittedController, InverseTraining};
use hysteron_learn::FitReport;
use hysteron_report::verdict::Verdict;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::shared::outcome::MetricsFormat;
use crate::shared::recording_checks::Findings;
use crate::shared::training;
use crate::{COMMIT, Context};

/// The outcome of `train`.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Outcome {
    /// Format of the file.
    pub format: MetricsFormat,
    /// Its version.
    pub version: u32,
    /// Whether the controller can be used.
    pub verdict: Verdict,
    /// Learning curve, and errors in validation next to those of the baselines: one entry.
    pub networks: Vec<FitReport>,
    /// Where the network does no better than a baseline, and kinds of motion that are validated on nowhere.
    pub warnings: Vec<String>,
    /// Warnings about the recordings.
    #[serde(default)]
    pub recording_warnings: Vec<Warning>,
    /// Data and options, as the checkpoint holds them.
    pub training: InverseTraining,
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
        data: &Dataset,
        fitted: &FittedController,
        findings: &Findings,
        context: &Context,
    ) -> Self {
        let networks = vec![fitted.report.clone()];
        let mut warnings = training::losses(&networks);
        for (kind, names) in data.unvalidated() {
            let names = names.join(", ");
            warnings.push(format!("motion of kind {kind} is learned from and validated on nowhere: {names}"));
        }
        Self {
            format: MetricsFormat,
            version: 1,
            verdict: training::verdict(&networks),
            networks,
            warnings,
            recording_warnings: findings.warnings().to_vec(),
            training: fitted.model.training.clone(),
            command: context.command.clone(),
            commit: COMMIT.to_owned(),
        }
    }
}
