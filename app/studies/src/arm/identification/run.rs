//! The run of `study identification`.

use std::path::Path;

use hysteron_workflow::shared::outputs::Outputs;
use hysteron_workflow::{Context, WorkflowError};

use super::cells::{IdentificationOptions, identification_study};
use super::{options::Options, outcome::Outcome, page};
use crate::runner;

/// Runs the study with as many noise seeds; recorded friction where there is data.
///
/// # Errors
/// Cells of another study, recordings that cannot be read, files that cannot be written, an interruption.
pub fn run(options: &Options, context: &Context) -> Result<Outcome, WorkflowError> {
    let franka = options.data.as_ref().map(|data| data.join("friction-franka"));
    let amount = IdentificationOptions { seeds: options.seeds as u64 };
    let compute = |cells: &Path, listener: runner::Listener<'_>| {
        Ok(identification_study(cells, franka.as_deref(), amount, listener)?)
    };
    runner::run(&options.out, Outputs::default(), context, compute, |study| {
        let outcome = Outcome::new(&study, context);
        page::write(&options.out, &study, &outcome)?;
        Ok(outcome)
    })
}
