//! Options of `hysteron generate`.

use std::path::PathBuf;

use super::shard::Shard;
use crate::shared::body::RobotBodyOptions;

/// Run a plan on the calibrated twin: synthetic data
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
    /// Plan file (.toml), or the name of a built-in plan, run without changes [default: synthetic, made smaller until it stays
    /// within the strokes and rates of the recordings that the checkpoint was trained on, or of --real]
    #[cfg_attr(feature = "clap", arg(long, value_name = "PLAN"))]
    pub plan: Option<String>,
    /// Folder to write to
    #[cfg_attr(feature = "clap", arg(long, value_name = "DIR"))]
    pub out: PathBuf,
    /// Only the I-th of N parts of the trajectories
    #[cfg_attr(feature = "clap", arg(long, value_name = "I/N"))]
    pub shard: Option<Shard>,
    /// Recordings of the robot, or folders of them, to compare with on the card
    #[cfg_attr(feature = "clap", arg(long, value_name = "REC", num_args = 1..))]
    pub real: Vec<PathBuf>,
    /// Write the figure as .png too
    #[cfg_attr(feature = "clap", arg(long))]
    pub png: bool,
}
