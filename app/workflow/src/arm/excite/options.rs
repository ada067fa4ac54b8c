//! Options of `arm excite`.

use std::path::PathBuf;

use crate::arm::RobotOptions;

/// Shape of a motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum Shape {
    /// Fourier series of least condition number
    Fourier,
    /// Polynomial of fifth order from rest to rest
    Quintic,
    /// Sinusoidal acceleration from rest to rest
    Cycloid,
}

/// Design a motion that excites the parameters of an arm
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    /// File of URDF or MJCF, or name of a built-in robot
    pub model: String,
    /// How the robot is read
    #[cfg_attr(feature = "clap", command(flatten))]
    pub robot_options: RobotOptions,
    /// Where the motion goes, .csv or .parquet
    #[cfg_attr(feature = "clap", arg(long, value_name = "REC"))]
    pub out: PathBuf,
    /// Shape of the motion
    #[cfg_attr(feature = "clap", arg(long, value_enum, default_value = "fourier"))]
    pub shape: Shape,
    /// Duration [default: 10 of a Fourier series, else as fast as limits allow]
    #[cfg_attr(feature = "clap", arg(long, value_name = "S", allow_negative_numbers = true))]
    pub duration_s: Option<f64>,
    /// Harmonics of the series
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value = "5", value_parser = clap::value_parser!(u16).range(2..=20)))]
    pub harmonics: u16,
    /// Most generations of the search
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value = "150", value_parser = clap::value_parser!(u32).range(1..=100_000)))]
    pub generations: u32,
    /// Seed of the search
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value = "1"))]
    pub seed: u64,
    /// Coordinates at the start, in rad or m
    #[cfg_attr(
        feature = "clap",
        arg(long, value_name = "Q,...", value_delimiter = ',', allow_negative_numbers = true)
    )]
    pub from: Vec<f64>,
    /// Coordinates at the end, in rad or m
    #[cfg_attr(
        feature = "clap",
        arg(long, value_name = "Q,...", value_delimiter = ',', allow_negative_numbers = true)
    )]
    pub to: Vec<f64>,
    /// Part of every limit that is used
    #[cfg_attr(
        feature = "clap",
        arg(long, value_name = "PART", default_value = "0.9", allow_negative_numbers = true)
    )]
    pub limits: f64,
    /// Greatest speed of joints whose file has none, in rad/s or m/s
    #[cfg_attr(feature = "clap", arg(long, value_name = "SPEED", allow_negative_numbers = true))]
    pub speed_limit: Option<f64>,
    /// Greatest acceleration of all joints, in rad/s^2 or m/s^2
    #[cfg_attr(feature = "clap", arg(long, value_name = "ACCELERATION", allow_negative_numbers = true))]
    pub acceleration_limit: Option<f64>,
    /// Rate of the rows
    #[cfg_attr(
        feature = "clap",
        arg(long, value_name = "HZ", default_value = "100", allow_negative_numbers = true)
    )]
    pub rate: f64,
    /// Folder for figures, report.html and metrics.json
    #[cfg_attr(feature = "clap", arg(long, value_name = "DIR"))]
    pub figures: Option<PathBuf>,
    /// Write each figure as .png too
    #[cfg_attr(feature = "clap", arg(long, requires = "figures"))]
    pub png: bool,
}
