//! Options of `study neural` and `study neural-networks`.

use std::path::PathBuf;

use hysteron_workflow::shared::number;

/// Actuators learned from telemetry, compared with published tables and simple baselines (NeuralActuator)
#[derive(Debug, Clone, clap::Args)]
pub struct Options {
    /// Folder of NAD (CSV), or of recordings by `hysteron arm generate` [default: the virtual arm]
    #[arg(long, value_name = "DIR")]
    pub data: Option<PathBuf>,
    /// Folder for cells, report.html and metrics.json
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// Seeds of networks
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = number::count::<32>)]
    pub seeds: usize,
    /// The first seed, so that machines can share the study: put their cells into one DIR/cells
    #[arg(long, value_name = "SEED", default_value_t = 0, value_parser = number::up_to::<10_000>)]
    pub first_seed: u32,
    /// One seed of small networks, minutes for all cells
    #[arg(long)]
    pub quick: bool,
}
