//! Options of `study run`.

use std::path::PathBuf;

/// Run a study: record, calibrate, identify, learn, track, evaluate; ends in one report
#[derive(Debug, Clone, clap::Args)]
pub struct Options {
    /// Study file, .toml
    pub study: PathBuf,
    /// Folder to write to [default: out/NAME]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
}
