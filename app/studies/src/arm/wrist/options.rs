//! Options of `study wrist`.

use std::path::PathBuf;

use hysteron_workflow::shared::number;

/// Interaction torques of a simulated wrist exoskeleton, by nine methods (Saadatzi et al. 2019); a quarter of an hour
#[derive(Debug, Clone, clap::Args)]
pub struct Options {
    /// Folder for cells, report.html and metrics.json
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// Noise seeds of every cell
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = number::count::<32>)]
    pub seeds: usize,
}
