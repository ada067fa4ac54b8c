//! Options of `arm evaluate`.

use std::path::PathBuf;

use crate::arm::RobotOptions;

/// Compare the predictions of a learned model with recordings
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    /// Model by hysteron arm fit
    pub model: PathBuf,
    /// Recordings to compare with: one for a model of inverse dynamics; for a neural actuator any number, or folders, without
    /// those called train or validation
    #[cfg_attr(feature = "clap", arg(required = true, value_name = "REC"))]
    pub recordings: Vec<PathBuf>,
    /// Where the parts of the torque go, .csv or .parquet; of a neural actuator, every number as JSON
    #[cfg_attr(feature = "clap", arg(long, value_name = "FILE"))]
    pub out: Option<PathBuf>,
    /// Folder for report.html and metrics.json, of a neural actuator
    #[cfg_attr(feature = "clap", arg(long, value_name = "DIR"))]
    pub figures: Option<PathBuf>,
    /// The arm of a neural actuator: a file of URDF or MJCF, or a built-in name
    #[cfg_attr(feature = "clap", arg(long, value_name = "MODEL", default_value = "open-manipulator-x"))]
    pub robot: String,
    /// How the robot is read
    #[cfg_attr(feature = "clap", command(flatten))]
    pub robot_options: RobotOptions,
    /// Without recordings whose path contains this; may be repeated
    #[cfg_attr(feature = "clap", arg(long, value_name = "TEXT"))]
    pub leave_out: Vec<String>,
    /// Recordings whose path contains this move freely: a sample without label of force is one of no force; may be repeated
    #[cfg_attr(feature = "clap", arg(long, value_name = "TEXT", default_value = "force_unlabeled"))]
    pub free: Vec<String>,
    /// Recordings or folders to which detectors of a degraded motor are fitted, as baselines of the network
    #[cfg_attr(feature = "clap", arg(long, value_name = "REC", num_args = 1..))]
    pub detectors: Vec<PathBuf>,
    /// Velocities above this are noise, where accelerations are differences of them
    #[cfg_attr(feature = "clap", arg(long, value_name = "HZ", default_value_t = 10.0, value_parser = crate::shared::number::cutoff_hz))]
    pub cutoff: f64,
}
