//! The public function of the verb; the recipe is that of every run.

use super::options::Options;
use crate::shared::run::{self, Outcome, Task};
use crate::{Context, WorkflowError};

/// Runs the verb.
///
/// # Errors
/// Bad input; an interruption; a sample without a solution.
pub fn run(options: &Options, context: &Context) -> Result<Outcome, WorkflowError> {
    let residual = options.residual.as_deref();
    Ok(run::run(Task::Simulate, &options.strokes, &options.run, residual, context)?)
}
