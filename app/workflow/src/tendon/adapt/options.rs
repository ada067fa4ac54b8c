//! Options of `adapt`.

use std::path::PathBuf;

#[cfg(feature = "clap")]
use hysteron_twin::residual::AdaptOptions;

use crate::shared::body::RobotBodyOptions;

/// Adapt a calibrated twin to new recordings
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    /// Checkpoint by hysteron fit-residual, or by this verb
    #[cfg_attr(feature = "clap", arg(value_name = "CKPT"))]
    pub checkpoint: PathBuf,
    /// Recordings of the robot, .parquet or .csv, or folders of them; in the order of their names
    #[cfg_attr(feature = "clap", arg(required = true, value_name = "REC"))]
    pub recordings: Vec<PathBuf>,
    /// Scene file of the robot (scene.toml)
    #[cfg_attr(feature = "clap", arg(long, value_name = "SCENE"))]
    pub scene: PathBuf,
    /// The body that moves it.
    #[cfg_attr(feature = "clap", command(flatten))]
    pub body: RobotBodyOptions,
    /// Recordings of the robot as it was when its twin was calibrated, of the same kinds of motion: an error that the twin had on
    /// these too shows no change [default: the error of the networks in validation]
    #[cfg_attr(feature = "clap", arg(long, value_name = "REC", num_args = 1..))]
    pub reference: Vec<PathBuf>,
    /// Checkpoint to write, .safetensors
    #[cfg_attr(feature = "clap", arg(long, value_name = "CKPT"))]
    pub out: PathBuf,
    /// Folder for metrics.json [default: OUT without its ending]
    #[cfg_attr(feature = "clap", arg(long, value_name = "DIR"))]
    pub figures: Option<PathBuf>,
    /// Time after which the weight of a sample is 1/e
    #[cfg_attr(feature = "clap", arg(long, value_name = "S", default_value_t = AdaptOptions::default().memory_s, value_parser = crate::shared::number::time_s))]
    pub memory_s: f64,
}
