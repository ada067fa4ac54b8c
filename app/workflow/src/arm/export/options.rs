//! Options of `arm export`.

use std::path::PathBuf;

use crate::arm::RobotOptions;

/// Write a robot as URDF, MJCF or a table of parameters
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    /// File of URDF or MJCF, or name of a built-in robot
    pub model: String,
    /// How the robot is read
    #[cfg_attr(feature = "clap", command(flatten))]
    pub robot_options: RobotOptions,
    /// Where it goes: .urdf, .xml or .csv
    #[cfg_attr(feature = "clap", arg(long, value_name = "FILE"))]
    pub out: PathBuf,
    /// Table with a row for each joint, whose parameters replace those of the robot
    #[cfg_attr(feature = "clap", arg(long, value_name = "CSV"))]
    pub parameters: Option<PathBuf>,
    /// The joints of an MJCF alone
    #[cfg_attr(feature = "clap", arg(long))]
    pub joints: bool,
}
