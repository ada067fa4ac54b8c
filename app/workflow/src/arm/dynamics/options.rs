//! Options of `arm dynamics`.

use std::path::PathBuf;

use crate::arm::RobotOptions;

/// Compute the dynamics of every row of states
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    /// File of URDF or MJCF, name of a built-in robot, or model by hysteron arm fit delan
    pub model: String,
    /// How the robot is read
    #[cfg_attr(feature = "clap", command(flatten))]
    pub robot_options: RobotOptions,
    /// States, .csv or .parquet
    #[cfg_attr(feature = "clap", arg(long, value_name = "REC"))]
    pub states: PathBuf,
    /// Where the results go, .csv or .parquet
    #[cfg_attr(feature = "clap", arg(long, value_name = "REC"))]
    pub out: PathBuf,
    /// Frame whose position and Jacobian are written [default: the last of the robot]
    #[cfg_attr(feature = "clap", arg(long, value_name = "NAME"))]
    pub frame: Option<String>,
    /// All derivatives too
    #[cfg_attr(feature = "clap", arg(long))]
    pub derivatives: bool,
}
