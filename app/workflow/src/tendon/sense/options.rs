//! Options of `sense`.

use std::path::PathBuf;

use crate::shared::body::RobotBodyOptions;

/// Estimate tensions and the force on the tip from a recording
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    /// Scene file of the robot (scene.toml)
    pub scene: PathBuf,
    /// The body that moves it.
    #[cfg_attr(feature = "clap", command(flatten))]
    pub body: RobotBodyOptions,
    /// Recording of strokes and tip, .parquet or .csv; with ticks and loads where there are servos
    #[cfg_attr(feature = "clap", arg(value_name = "REC"))]
    pub recording: PathBuf,
    /// Sensor by hysteron fit-sensor
    #[cfg_attr(feature = "clap", arg(long, value_name = "FILE"))]
    pub sensor: PathBuf,
    /// Residual network of the twin that the sensor was fitted with
    #[cfg_attr(feature = "clap", arg(long, value_name = "CKPT"))]
    pub residual: Option<PathBuf>,
    /// Recording to write, .parquet or .csv
    #[cfg_attr(feature = "clap", arg(long, value_name = "REC"))]
    pub out: PathBuf,
    /// Folder for figures, report.html and metrics.json
    #[cfg_attr(feature = "clap", arg(long, value_name = "DIR"))]
    pub figures: Option<PathBuf>,
    /// Write each figure as .png too
    #[cfg_attr(feature = "clap", arg(long, requires = "figures"))]
    pub png: bool,
}
