//! Options of `study scara`.

use std::path::PathBuf;

use hysteron_workflow::shared::number;

/// External torques of a simulated SCARA: friction, momentum observers, collisions (Wan et al. 2026); a quarter of an hour
#[derive(Debug, Clone, clap::Args)]
pub struct Options {
    /// Folder for cells, report.html and metrics.json
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// Trials, each with 48 s of contact and 15 min of collisions
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = number::count::<32>)]
    pub seeds: usize,
}
