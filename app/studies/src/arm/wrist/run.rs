//! The run of `study wrist`.

use hysteron_workflow::shared::outputs::Outputs;
use hysteron_workflow::{Context, WorkflowError};

use super::{cells::wrist_study, options::Options, outcome::Outcome, page};
use crate::runner;

/// Runs the study, every cell with as many noise seeds.
///
/// # Errors
/// Cells of another study, files that cannot be written, an interruption.
pub fn run(options: &Options, context: &Context) -> Result<Outcome, WorkflowError> {
    let compute = |cells: &std::path::Path, listener: runner::Listener<'_>| {
        Ok(wrist_study(cells, options.seeds as u64, listener)?)
    };
    runner::run(&options.out, Outputs::default(), context, compute, |study| {
        let outcome = Outcome::new(&study, context);
        page::write(&options.out, &study, &outcome)?;
        Ok(outcome)
    })
}
