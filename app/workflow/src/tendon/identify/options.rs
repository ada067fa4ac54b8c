//! Options of `identify`.

use std::path::PathBuf;

use crate::shared::body::RobotBodyOptions;

/// More than any sample needs.
pub const MAX_ROUNDS: usize = 100;

/// Find the auxiliary tendons' strokes that make the twin follow measured tips (CoReAct)
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    /// Scene file of the robot (scene.toml), with auxiliary tendons
    pub scene: PathBuf,
    /// The body that moves it.
    #[cfg_attr(feature = "clap", command(flatten))]
    pub body: RobotBodyOptions,
    /// Recordings, .parquet or .csv, or folders of them
    #[cfg_attr(feature = "clap", arg(required = true, value_name = "REC"))]
    pub recordings: Vec<PathBuf>,
    /// Folder to write to
    #[cfg_attr(feature = "clap", arg(long, value_name = "DIR"))]
    pub out: PathBuf,
    /// Weight of the squared strokes, over the mean squared effect of a stroke on the tip
    #[cfg_attr(feature = "clap", arg(long, value_name = "GAMMA", default_value_t = 1e-4, value_parser = crate::shared::number::weight))]
    pub regularisation: f64,
    /// Match the tip's orientation too, where recorded: a radian counts as much as this distance
    #[cfg_attr(feature = "clap", arg(long, value_name = "MM", value_parser = crate::shared::number::length_mm))]
    pub orientation_mm: Option<f64>,
    /// Rounds of QP and simulation per sample at most
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value_t = 2, value_parser = crate::shared::number::count::<MAX_ROUNDS>))]
    pub rounds: usize,
    /// Let this network choose the strokes, instead of QPs
    #[cfg_attr(feature = "clap", arg(long, value_name = "CKPT", conflicts_with_all = ["regularisation", "orientation_mm", "rounds"]))]
    pub residual: Option<PathBuf>,
    /// Skip recordings that cannot be used, with a warning, instead of stopping
    #[cfg_attr(feature = "clap", arg(long))]
    pub skip_bad: bool,
}
