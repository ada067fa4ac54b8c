//! Force at the tip of an arm from what its servos report: motors, friction and noise are identified on contact-free motion of the same
//! arm, then external torques of an observer go to the tip.

mod baselines;
mod drive;
mod estimator;
mod identify;
mod telemetry;

pub use baselines::{BaselineObservers, LinearDrive};
pub use drive::{STANDSTILL_SPEED, ServoDrive};
pub use telemetry::ServoForceTelemetry;

pub use estimator::{DriveObserver, ForceEstimator, GAIN, estimators, tip_force};

use hysteron_actuator::CatalogueDrive;
use hysteron_base::BadInput;

use hysteron_arm_dynamics::Model;

/// Name of the frame on which forces act.
pub const TIP: &str = "end_effector_link";

/// The first `n` joints of `model` with the rotors of a servo XM430-W350, all others locked at zero: what estimators know of an arm.
///
/// # Errors
/// `BadInput` where the model has fewer joints, or no frame `end_effector_link`.
pub fn observed_arm(model: &Model, n: usize) -> Result<Model, BadInput> {
    if model.n_joints() < n {
        return Err(BadInput::new("robot", format!("{n} joints or more"), model.n_joints().to_string()));
    }
    let locked: Vec<(&str, f64)> =
        model.joints()[n..].iter().map(|joint| (joint.name.as_str(), 0.0)).collect();
    let mut arm = if locked.is_empty() { model.clone() } else { model.with_locked(&locked)? };
    let armature = CatalogueDrive::named("xm430-w350")?.drive.gear.armature;
    for joint in &model.joints()[..n] {
        arm = arm.with_rotor(&joint.name, armature, 1.0)?;
    }
    arm.frame(TIP)?;
    Ok(arm)
}
