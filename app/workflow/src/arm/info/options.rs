//! Options of `arm info` and `arm check`.

use crate::arm::RobotOptions;

/// Print the joints of a robot: tree, masses, ranges, reach
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    /// File of URDF or MJCF, or name of a built-in robot
    pub model: String,
    /// How it is read
    #[cfg_attr(feature = "clap", command(flatten))]
    pub robot_options: RobotOptions,
}

/// As info; fails where values are suspicious
///
/// Suspicious are masses and inertias that no physical body has, and lengths, masses and inertias that look like mm or g.
/// Exit code 2 where something is.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct CheckOptions {
    /// File of URDF or MJCF, or name of a built-in robot
    pub model: String,
    /// How it is read
    #[cfg_attr(feature = "clap", command(flatten))]
    pub robot_options: RobotOptions,
}
