//! Options of `study cloning`.

use std::path::PathBuf;

use hysteron_workflow::shared::number;

/// Policies that handle an object of unknown mass on the virtual arm, cloned with and without a force; minutes
#[derive(Debug, Clone, clap::Args)]
pub struct Options {
    /// Folder for report.html and metrics.json
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// Policies of a row
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = number::count::<32>)]
    pub seeds: usize,
    /// Actuator by hysteron arm fit neural --sensing observer that estimates the force; without one that row is skipped
    #[arg(long, value_name = "FILE")]
    pub actuator: Option<PathBuf>,
    /// One policy of a row and twelve trials
    #[arg(long)]
    pub quick: bool,
}
