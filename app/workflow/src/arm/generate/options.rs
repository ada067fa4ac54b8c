//! Options of `arm generate`.

use std::path::PathBuf;

/// Record trajectories like those of the data set NAD with the virtual arm
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    /// Folder to write to: SUBSET/TASK/SPLIT/NUMBER.parquet, as in NAD
    #[cfg_attr(feature = "clap", arg(long, value_name = "DIR"))]
    pub out: PathBuf,
    /// Virtual arm: a file of TOML or a built-in name
    #[cfg_attr(feature = "clap", arg(long, value_name = "ARM", default_value = "open-manipulator-x"))]
    pub arm: String,
    /// Seed of the individual arm, its motions and its noise
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value_t = 0))]
    pub seed: u64,
    /// Only these subsets: `force_unlabeled`, `force_sensor`, `weight`, `motor_condition`; and `motor_faults`, which NAD does not have
    #[cfg_attr(feature = "clap", arg(long, value_name = "NAME,...", value_delimiter = ','))]
    pub subsets: Vec<String>,
    /// Only tasks whose names contain one of these, as in `sweep,pick_place`
    #[cfg_attr(feature = "clap", arg(long, value_name = "TEXT,...", value_delimiter = ','))]
    pub tasks: Vec<String>,
    /// Only these splits: train, validation, test
    #[cfg_attr(feature = "clap", arg(long, value_name = "NAME,...", value_delimiter = ','))]
    pub splits: Vec<String>,
    /// Only trajectories with these payloads, 0 for none
    #[cfg_attr(feature = "clap", arg(long, value_name = "G,...", value_delimiter = ','))]
    pub payloads_g: Vec<u32>,
    /// At most this many trajectories of a task and split
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", value_parser = crate::shared::number::count::<8>))]
    pub trajectories: Option<usize>,
}
