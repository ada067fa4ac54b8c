//! Options of `arm identify inertia`.

use std::path::PathBuf;

use hysteron_base::BadInput;

use crate::arm::RobotOptions;
use crate::arm::identify::MotionOptions;
use crate::shared::identification::{Results, positive};

/// Bodies, rotors and friction of all joints
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    /// File of URDF or MJCF, or name of a built-in robot
    pub model: String,
    /// How the robot is read
    #[cfg_attr(feature = "clap", command(flatten))]
    pub robot_options: RobotOptions,
    /// Recordings to fit
    #[cfg_attr(feature = "clap", arg(required = true, value_name = "REC"))]
    pub recordings: Vec<PathBuf>,
    /// Recording that is not fitted, to test on
    #[cfg_attr(feature = "clap", arg(long, value_name = "REC"))]
    pub test: Option<PathBuf>,
    /// Last part of the recordings that is not fitted, to test on
    #[cfg_attr(
        feature = "clap",
        arg(long, value_name = "PART", default_value_t = 0.0, allow_negative_numbers = true)
    )]
    pub hold_out: f64,
    /// Weight of the bodies in the robot's file, in samples
    #[cfg_attr(
        feature = "clap",
        arg(long, value_name = "N", default_value_t = 1.0, allow_negative_numbers = true)
    )]
    pub prior: f64,
    /// Identify the lead or lag of measured torques, and their frequency response
    #[cfg_attr(feature = "clap", arg(long))]
    pub response: bool,
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

impl Options {
    /// Refuses numbers that cannot be met.
    ///
    /// # Errors
    /// `BadInput` naming the option.
    pub(super) fn check(&self) -> Result<(), BadInput> {
        self.motion.check()?;
        positive("--prior", self.prior)?;
        if !(0.0..=0.9).contains(&self.hold_out) {
            return Err(BadInput::new("--hold-out", "a part from 0 to 0.9", self.hold_out.to_string()));
        }
        if self.test.is_some() && self.hold_out > 0.0 {
            return Err(BadInput::new("--hold-out", "this or --test", "both"));
        }
        Ok(())
    }
}
