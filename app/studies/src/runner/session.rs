//! A run of a study: its folder is locked, cells are done while their progress is shown, and the outcome is reported.

use std::path::Path;

use hysteron_workflow::shared::error::Cancelled;
use hysteron_workflow::shared::outputs::Outputs;
use hysteron_workflow::{Context, WorkflowError};

use super::cells::{Listener, StudyProgress};
use super::progress::Bar;

/// Runs a study: `compute` does its cells in the folder that it is given, which lies in `out`, and `report` writes what came
/// of them. `compute` gives nothing where the listener ended it.
///
/// # Errors
/// `BadInput` for a folder of another command; an interruption, with the folder of the finished cells; those of
/// `compute` and `report`.
pub fn run<T, O>(
    out: &Path,
    inputs: Outputs,
    context: &Context,
    compute: impl FnOnce(&Path, Listener<'_>) -> anyhow::Result<Option<T>>,
    report: impl FnOnce(T) -> anyhow::Result<O>,
) -> Result<O, WorkflowError> {
    let _lock = inputs.report("--out", Some(out)).check(context)?;
    context.listen();
    let cells = out.join("cells");
    let mut bar = Bar::new(context);
    let found = compute(&cells, &mut |p: &StudyProgress<'_>| bar.show(p))?;
    bar.clear();
    let found = found.filter(|_| !context.is_cancelled()).ok_or_else(|| {
        let kept = format!("; finished cells are in {}: the same command resumes", cells.display());
        anyhow::Error::new(Cancelled::new(kept))
    })?;
    let outcome = report(found)?;
    context.reported(out);
    Ok(outcome)
}
