//! Options of `study force`.

use std::path::PathBuf;

use hysteron_workflow::shared::number;

/// Force at the tip of an arm without a sensor, by the classical methods (Dou et al., table VI); a quarter of an hour
#[derive(Debug, Clone, clap::Args)]
pub struct Options {
    /// Folder of NAD (CSV), or of recordings by `hysteron arm generate` [default: the virtual arm]
    #[arg(long, value_name = "DIR")]
    pub data: Option<PathBuf>,
    /// Folder for cells, report.html and metrics.json
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// Individual virtual arms
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = number::count::<32>)]
    pub seeds: usize,
}
