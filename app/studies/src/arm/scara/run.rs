//! The run of `study scara`.

use hysteron_workflow::shared::outputs::Outputs;
use hysteron_workflow::{Context, WorkflowError};

use super::cells::{ScaraOptions, scara_study};
use super::{options::Options, outcome::Outcome, page};
use crate::runner;

/// Runs the study: one seed; four trials and three stretches for each of the number of seeds.
///
/// # Errors
/// Cells of another study, files that cannot be written, an interruption.
pub fn run(options: &Options, context: &Context) -> Result<Outcome, WorkflowError> {
    let amount = ScaraOptions { seed: 1, trials: 4 * options.seeds, stretches: 3 * options.seeds };
    let compute =
        |cells: &std::path::Path, listener: runner::Listener<'_>| Ok(scara_study(cells, amount, listener)?);
    runner::run(&options.out, Outputs::default(), context, compute, |study| {
        let outcome = Outcome::new(&study, context);
        page::write(&options.out, &study, &outcome)?;
        Ok(outcome)
    })
}
