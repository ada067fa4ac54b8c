//! Options of `rig recover`.

use std::path::PathBuf;

/// Open the journal of a run that crashed
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    /// Journal of the run
    pub journal: PathBuf,
    /// Recording to write, .parquet or .csv
    #[cfg_attr(feature = "clap", arg(long, value_name = "REC"))]
    pub out: PathBuf,
}
