//! Options of `arm adapt`.

use std::path::PathBuf;

use crate::arm::RobotOptions;

/// Adapt a neural actuator to an arm whose friction or drives have changed
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    /// Actuator by hysteron arm fit neural --prior servo
    pub actuator: PathBuf,
    /// Recordings of the changed arm: one to three are enough
    #[cfg_attr(feature = "clap", arg(required = true, value_name = "REC"))]
    pub recordings: Vec<PathBuf>,
    /// Actuator to write, .safetensors
    #[cfg_attr(feature = "clap", arg(long, value_name = "FILE"))]
    pub out: PathBuf,
    /// Updates of its network
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value_t = 100, value_parser = crate::shared::number::count::<100_000>))]
    pub updates: usize,
    /// The arm: a file of URDF or MJCF, or a built-in name
    #[cfg_attr(feature = "clap", arg(long, value_name = "MODEL", default_value = "open-manipulator-x"))]
    pub robot: String,
    /// How the robot is read
    #[cfg_attr(feature = "clap", command(flatten))]
    pub robot_options: RobotOptions,
}
