//! Options of `arm simulate`.

use std::path::PathBuf;

use crate::arm::RobotOptions;

/// Simulate the motion of an arm under recorded torques
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    /// File of URDF or MJCF, or name of a built-in robot
    pub model: String,
    /// How the robot is read
    #[cfg_attr(feature = "clap", command(flatten))]
    pub robot_options: RobotOptions,
    /// Torques, .csv or .parquet
    #[cfg_attr(feature = "clap", arg(long, value_name = "REC"))]
    pub torques: PathBuf,
    /// Where the motion goes, .csv or .parquet
    #[cfg_attr(feature = "clap", arg(long, value_name = "REC"))]
    pub out: PathBuf,
    /// Coordinates at the start, in rad or m [default: those of the first row of REC, where it has them, else zero]
    #[cfg_attr(
        feature = "clap",
        arg(long, value_name = "Q,...", value_delimiter = ',', allow_negative_numbers = true)
    )]
    pub start: Vec<f64>,
    /// Equal parts of the time between two rows
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value = "4", value_parser = clap::value_parser!(u16).range(1..=1000)))]
    pub substeps: u16,
    /// Folder for figures, report.html and metrics.json
    #[cfg_attr(feature = "clap", arg(long, value_name = "DIR"))]
    pub figures: Option<PathBuf>,
    /// Write each figure as .png too
    #[cfg_attr(feature = "clap", arg(long, requires = "figures"))]
    pub png: bool,
}
