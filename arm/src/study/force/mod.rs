//! Force at the tip without a sensor, by the classical estimators of table VI of Dou et al. (NeuralActuator): `arm study force`.
//!
//! Everything that estimators need is identified on contact-free training trajectories of the same arm; thresholds are learned
//! there too. Recordings come from whoever has them: the virtual arm, which shares no code with the estimators, or NAD itself.

mod identify;
mod methods;
mod run;
mod score;
mod telemetry;

pub use methods::{METHODS, PUBLISHED, TASKS};
pub use run::{ForceCell, ForceStudy, force_study};
pub use score::{FalseContacts, FreeRow, LoadedRow, Trace};
pub use telemetry::Telemetry;

use crate::Model;

/// Rows of the arm's joints that a study reads of a set of recordings.
#[derive(Debug, Clone, Default)]
pub struct ForceData {
    /// Contact-free, to identify with.
    pub training: Vec<Telemetry>,
    /// Contact-free, to count false contacts on; with their tasks.
    pub free: Vec<(String, Telemetry)>,
    /// With objects; with their tasks.
    pub loaded: Vec<(String, Telemetry)>,
}

/// The arm as estimators know it: the manufacturer's bodies, and rotors of the catalogue's servo.
///
/// # Errors
/// None that the built-in robot gives.
pub fn known_arm() -> Result<Model, hysteron_base::BadInput> {
    let fingers = [("gripper_left_joint", 0.0), ("gripper_right_joint", 0.0)];
    let mut model = Model::builtin("open-manipulator-x")?.with_locked(&fingers)?;
    let drive = hysteron_actuator::CatalogueDrive::named("xm430-w350")?.drive;
    for joint in ["joint1", "joint2", "joint3", "joint4"] {
        model = model.with_rotor(joint, drive.gear.armature, 1.0)?;
    }
    Ok(model)
}
