//! A run of a study of tendon robots: its folder is locked, and its outcome written.

use std::path::Path;

use hysteron_report::folder::ReportFolder;
use hysteron_report::page::Page;
use hysteron_workflow::shared::outputs::{OutputLock, Outputs};
use hysteron_workflow::{Context, WorkflowError};

use super::outcome::{Outcome, StudyMetrics};

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
        let lock = Outputs::default().report("--out", Some(out)).check(context)?;
        context.listen();
        Ok(Self { study, out, context, _lock: lock })
    }

    /// Writes `report.html` with its figures, and `metrics.json`.
    ///
    /// # Errors
    /// A figure that cannot be drawn; refusals of the file system.
    pub fn write<M: StudyMetrics>(&self, metrics: M) -> anyhow::Result<Outcome<M>> {
        let outcome = Outcome::new(self.study, metrics, self.context);
        let folder = ReportFolder { path: self.out, png: false };
        folder.write_metrics(&outcome)?;
        let mut page = Page::with_verdict(M::TITLE, &outcome.verdict, M::ABOUT, &outcome.command);
        outcome.metrics.tables().iter().for_each(|table| table.show(&mut page));
        page.heading("Figures");
        outcome.metrics.show(&folder, &mut page)?;
        folder.write_page(page, &outcome.commit)?;
        Ok(outcome)
    }

    /// Says where the report is.
    pub fn finish<M>(&self, outcome: Outcome<M>) -> Outcome<M> {
        self.context.reported(self.out);
        outcome
    }
}

/// Runs a study: `measure` gives its numbers, which are written to `out`.
///
/// # Errors
/// `BadInput` for a folder that is not this command's; those of `measure`.
pub(super) fn run<M: StudyMetrics>(
    study: &'static str,
    out: &Path,
    context: &Context,
    measure: impl FnOnce() -> anyhow::Result<M>,
) -> Result<Outcome<M>, WorkflowError> {
    let session = StudySession::begin(study, out, context)?;
    let outcome = session.write(measure()?)?;
    Ok(session.finish(outcome))
}
