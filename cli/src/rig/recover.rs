//! `hysteron rig recover`: from the journal of a run that crashed to its recording.

use std::path::PathBuf;

use hysteron_base::BadInput;
use hysteron_rig::session::recover;

use crate::terminal::say;

const HELP: &str = "\
A run that was killed leaves its rows in OUT.journal. At most the rows of the last half second, which still waited for \
the tracker, are missing. The journal is read and stays. (`hysteron record` does the same by itself when it is started \
again with the same --out.)

Example:
  hysteron rig recover out/circle.journal --out out/circle-recovered.parquet

Exit codes: 0 done, 1 failed, 2 bad input, or a journal without a single row.";

/// Open the journal of a run that crashed
#[derive(Debug, clap::Args)]
#[command(after_help = HELP)]
pub struct Arguments {
    /// Journal that the run has left
    journal: PathBuf,
    /// Recording to write, .parquet or .csv
    #[arg(long, value_name = "REC")]
    out: PathBuf,
}

/// Carries out the verb.
pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    if arguments.out.exists() {
        let place = arguments.out.display().to_string();
        return Err(BadInput::new(place, "a new file", "one that exists").into());
    }
    let (n_rows, n_gaps) = recover(&arguments.journal, &arguments.out)?;
    say(format_args!("{}: {n_rows} rows, {n_gaps} of them filled in", arguments.out.display()));
    Ok(())
}
