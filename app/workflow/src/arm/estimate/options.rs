//! Options of `arm estimate`.

use std::path::PathBuf;

use crate::arm::RobotOptions;

/// Estimate torques, force, contact and motor condition from servo telemetry, along a recording or live on a bus; or
/// external torques along a recording with learned dynamics
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    /// Actuator by hysteron arm fit neural --sensing observer, or model by hysteron arm fit delan
    pub actuator: PathBuf,
    /// Recording of the arm
    #[cfg_attr(
        feature = "clap",
        arg(value_name = "REC", required_unless_present = "live", conflicts_with = "live")
    )]
    pub recording: Option<PathBuf>,
    /// Estimate while a follower follows its leader, as `hysteron arm record` does: file of both arms (.toml)
    #[cfg_attr(feature = "clap", arg(long, value_name = "FILE"))]
    pub live: Option<PathBuf>,
    /// Live: end after that many seconds [default: at Ctrl-C]
    #[cfg_attr(
        feature = "clap",
        arg(long, value_name = "SECONDS", allow_negative_numbers = true, requires = "live")
    )]
    pub seconds: Option<f64>,
    /// Recording to write, .csv or .parquet
    #[cfg_attr(feature = "clap", arg(long, value_name = "FILE"))]
    pub out: PathBuf,
    /// The arm: a file of URDF or MJCF, or a built-in name
    #[cfg_attr(feature = "clap", arg(long, value_name = "MODEL", default_value = "open-manipulator-x"))]
    pub robot: String,
    /// How the robot is read
    #[cfg_attr(feature = "clap", command(flatten))]
    pub robot_options: RobotOptions,
    /// Gain of the momentum observer [1/s], with a model by hysteron arm fit delan
    #[cfg_attr(feature = "clap", arg(long, value_name = "GAIN", default_value_t = 25.0, value_parser = crate::shared::number::gain))]
    pub gain: f64,
}
