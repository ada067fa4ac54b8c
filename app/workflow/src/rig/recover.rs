//! `hysteron rig recover`: from the journal of a run that crashed to its recording.

use std::path::PathBuf;

use hysteron_base::BadInput;
use hysteron_rig::session::recover;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::Context;

/// Open the journal of a run that crashed
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    /// Journal that the run has left
    pub journal: PathBuf,
    /// Recording to write, .parquet or .csv
    #[cfg_attr(feature = "clap", arg(long, value_name = "REC"))]
    pub out: PathBuf,
}

/// The outcome of `rig recover`.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Outcome {
    /// The recording.
    pub recording: PathBuf,
    /// Number of samples.
    pub rows: usize,
    /// Samples that were not measured and are filled in.
    pub filled_in: usize,
}

impl crate::shared::outcome::Outcome for Outcome {}

/// Carries out the verb.
///
/// # Errors
/// Bad input; a journal without a single row.
pub fn run(options: &Options, context: &Context) -> anyhow::Result<Outcome> {
    if options.out.exists() {
        let place = options.out.display().to_string();
        return Err(BadInput::new(place, "a new file", "one that exists").into());
    }
    let (n_rows, n_gaps) = recover(&options.journal, &options.out)?;
    context.print(format_args!("{}: {n_rows} rows, {n_gaps} of them filled in", options.out.display()));
    Ok(Outcome { recording: options.out.clone(), rows: n_rows, filled_in: n_gaps })
}
