//! The public function of the verb; the recipe is that of every run.

use super::options::Options;
use crate::shared::run::{self, Outcome, Task};
use crate::{Context, WorkflowError};

/// Runs the verb.
///
/// # Errors
/// Bad input; an interruption; a sample without a solution.
pub fn run(options: &Options, context: &Context) -> Result<Outcome, WorkflowError> {
    let task = Task::Reach(1e-3 * options.tolerance_mm);
    Ok(run::run(task, &options.goals, &options.run, None, context)?)
}
