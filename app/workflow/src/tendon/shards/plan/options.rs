//! Options of `hysteron shards plan`.

use std::path::PathBuf;

use crate::shared::body::RobotBodyOptions;

/// Plan a set of synthetic data that many machines make
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    /// Scene file of the robot (scene.toml)
    pub scene: PathBuf,
    /// The body that moves it.
    #[cfg_attr(feature = "clap", command(flatten))]
    pub body: RobotBodyOptions,
    /// Checkpoint by hysteron fit-residual
    #[cfg_attr(feature = "clap", arg(long, value_name = "CKPT"))]
    pub residual: Option<PathBuf>,
    /// Plan file (.toml), of any number of trajectories, or the name of a built-in plan [default: that of generate]
    #[cfg_attr(feature = "clap", arg(long, value_name = "PLAN"))]
    pub plan: Option<String>,
    /// Place of the set: a folder that all machines see, or s3://, gs:// or az://
    #[cfg_attr(feature = "clap", arg(long, value_name = "URL"))]
    pub to: String,
    /// Number of shards
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", conflicts_with = "rows_per_shard"))]
    pub shards: Option<usize>,
    /// Samples of a shard, about [default: 100000]
    #[cfg_attr(feature = "clap", arg(long, value_name = "N"))]
    pub rows_per_shard: Option<u64>,
    /// Trajectories to simulate for the estimate of time and size; 0 makes none
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value_t = 2))]
    pub measure: usize,
}
