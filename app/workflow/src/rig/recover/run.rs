//! The recovery of a journal.

use hysteron_base::BadInput;
use hysteron_rig::session::recover;

use super::options::Options;
use super::outcome::Outcome;
use crate::{Context, WorkflowError};

/// Runs the verb.
///
/// # Errors
/// Bad input; a journal without a single row.
pub fn run(options: &Options, context: &Context) -> Result<Outcome, WorkflowError> {
    Ok(recover_journal(options, context)?)
}

fn recover_journal(options: &Options, context: &Context) -> anyhow::Result<Outcome> {
    if options.out.exists() {
        let place = options.out.display().to_string();
        return Err(BadInput::new(place, "a new file", "one that exists").into());
    }
    let (n_rows, n_gaps) = recover(&options.journal, &options.out)?;
    context.print(format_args!("{}: {n_rows} rows, {n_gaps} of them filled in", options.out.display()));
    Ok(Outcome { recording: options.out.clone(), rows: n_rows, filled_in: n_gaps })
}
