//! Options of `fit-sensor`.

use std::path::PathBuf;

use hysteron_base::BadInput;

use crate::shared::body::RobotBodyOptions;

/// Fit the force sensor to recordings without contact
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    /// Scene file of the robot (scene.toml)
    pub scene: PathBuf,
    /// The body that moves it.
    #[cfg_attr(feature = "clap", command(flatten))]
    pub body: RobotBodyOptions,
    /// Recordings without contact, with holds between motions, or folders of them; where one has tip_force_x_n,
    /// tip_force_y_n, tip_force_z_n it calibrates the stiffness of the tip
    #[cfg_attr(feature = "clap", arg(required = true, value_name = "REC"))]
    pub recordings: Vec<PathBuf>,
    /// Residual network of the twin
    #[cfg_attr(feature = "clap", arg(long, value_name = "CKPT"))]
    pub residual: Option<PathBuf>,
    /// Result of `hysteron identify-servo` where tensions were known: the scale of the loads is its mean over the servos
    #[cfg_attr(feature = "clap", arg(long, value_name = "FILE", conflicts_with = "stall_torque"))]
    pub servos: Option<PathBuf>,
    /// Torque of a servo at full load [default: an XL430-W250's]
    #[cfg_attr(feature = "clap", arg(long, value_name = "N_M", default_value_t = 1.4))]
    pub stall_torque: f64,
    /// Sensor to write, .json
    #[cfg_attr(feature = "clap", arg(long, value_name = "FILE"))]
    pub out: PathBuf,
}

impl Options {
    /// # Errors
    /// `BadInput` for a torque that no servo has.
    pub(super) fn check(&self) -> Result<(), BadInput> {
        if self.stall_torque > 0.0 && self.stall_torque.is_finite() {
            return Ok(());
        }
        Err(BadInput::new("--stall-torque", "a finite number > 0", self.stall_torque.to_string()))
    }
}
