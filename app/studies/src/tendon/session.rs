//! A run of a study of tendon robots: its folder is locked, and its outcome written.

use std::path::Path;

use hysteron_report::page::write_metrics;
use hysteron_workflow::shared::outputs::{OutputLock, Outputs};
use hysteron_workflow::{Context, WorkflowError};
use serde::Serialize;

use super::outcome::Outcome;

/// A run of a study.
pub(super) struct StudySession<'a> {
    study: &'static str,
    out: &'a Path,
    context: &'a Context<'a>,
    _lock: OutputLock,
}

impl<'a> StudySession<'a> {
    /// Claims the folder `out` for a study.
    ///
    /// # Errors
    /// `BadInput` for a folder that is not this command's.
    pub fn begin(study: &'static str, out: &'a Path, context: &'a Context<'a>) -> anyhow::Result<Self> {
        let outputs = Outputs::default().folder("--out", out).file("--out", out.join("metrics.json"));
        let lock = outputs.check(context)?;
        context.listen();
        Ok(Self { study, out, context, _lock: lock })
    }

    /// Writes `metrics.json`.
    ///
    /// # Errors
    /// Refusals of the file system.
    pub fn write<M: Serialize>(&self, metrics: M) -> anyhow::Result<Outcome<M>> {
        let outcome = Outcome::new(self.study, metrics, self.context);
        write_metrics(self.out, &outcome)?;
        Ok(outcome)
    }

    /// Says where the outcome is.
    pub fn finish<M>(&self, outcome: Outcome<M>) -> Outcome<M> {
        self.context.wrote(&self.out.join("metrics.json"));
        outcome
    }
}

/// Runs a study: `measure` gives its numbers, which are written to `out`.
///
/// # Errors
/// `BadInput` for a folder that is not this command's; those of `measure`.
pub(super) fn run<M: Serialize>(
    study: &'static str,
    out: &Path,
    context: &Context,
    measure: impl FnOnce() -> anyhow::Result<M>,
) -> Result<Outcome<M>, WorkflowError> {
    let session = StudySession::begin(study, out, context)?;
    let outcome = session.write(measure()?)?;
    Ok(session.finish(outcome))
}
