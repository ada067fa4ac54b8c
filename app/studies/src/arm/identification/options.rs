//! Options of `study identification`.

use std::path::PathBuf;

use hysteron_workflow::shared::number;

/// Friction and bodies of arms by every method of identification; minutes
#[derive(Debug, Clone, clap::Args)]
pub struct Options {
    /// Folder of public recordings, with friction-franka/ [default: simulated arms alone]
    #[arg(long, value_name = "DIR")]
    pub data: Option<PathBuf>,
    /// Folder for cells, report.html and metrics.json
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// Noise seeds
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = number::count::<32>)]
    pub seeds: usize,
}
