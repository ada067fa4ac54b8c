//! Options of `arm identify payload`.

use std::path::PathBuf;

use crate::arm::RobotOptions;
use crate::arm::identify::MotionOptions;
use crate::shared::identification::Results;

/// Payload of an arm
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    /// File of URDF or MJCF, or name of a built-in robot
    pub model: String,
    /// How the robot is read
    #[cfg_attr(feature = "clap", command(flatten))]
    pub robot_options: RobotOptions,
    /// Recordings with the payload
    #[cfg_attr(feature = "clap", arg(required = true, value_name = "REC"))]
    pub recordings: Vec<PathBuf>,
    /// Recordings without
    #[cfg_attr(feature = "clap", arg(long, required = true, value_name = "REC", num_args = 1..))]
    pub bare: Vec<PathBuf>,
    /// Frame that holds the payload [default: the robot's last]
    #[cfg_attr(feature = "clap", arg(long, value_name = "NAME"))]
    pub frame: Option<String>,
    /// File for the robot as identified: .urdf, .xml (MJCF) or .csv (parameters)
    #[cfg_attr(feature = "clap", arg(long, value_name = "FILE"))]
    pub robot: Option<PathBuf>,
    /// How they are read.
    #[cfg_attr(feature = "clap", command(flatten))]
    pub motion: MotionOptions,
    /// Where the results go.
    #[cfg_attr(feature = "clap", command(flatten))]
    pub results: Results,
}
