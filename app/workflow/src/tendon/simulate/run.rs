//! The public function of the verb; the recipe is that of every run.

use super::options::Options;
use crate::shared::run::{self, ModelFile, Outcome, Task};
use crate::{Context, WorkflowError};

/// Runs the verb.
///
/// # Errors
/// Bad input; an interruption; a sample without a solution.
pub fn run(options: &Options, context: &Context) -> Result<Outcome, WorkflowError> {
    let model = match (&options.residual, &options.reduced) {
        (Some(path), _) => ModelFile::Residual(path),
        (None, Some(path)) => ModelFile::Chain(path),
        (None, None) => ModelFile::Scene,
    };
    Ok(run::run(Task::Simulate, &options.strokes, &options.run, model, context)?)
}
