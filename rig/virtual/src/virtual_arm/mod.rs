//! The virtual arm: a follower of four joints with a gripper, its servos, what it carries and what pushes it.
//!
//! It is modelled on the arm of the data set NAD. Its bodies, gears and motors are written for it alone and share neither code nor
//! parameters with the estimators of `hysteron-arm-estimation`, which are tested on it. The equations are in `docs/virtual-arm.md`.
//!
//! ```
//! use hysteron_base::Metadata;
//! use hysteron_virtual_rig::virtual_arm::{VirtualArm, data_set};
//!
//! let arm = VirtualArm::preset("open-manipulator-x")?.individual(1);
//! let planned = &data_set()[0];
//! let recording = arm.record(&planned.trial, 1, &planned.name(), Metadata::default())?;
//! assert!(recording.channel("truth_friction_2_n_m").is_some());
//! # Ok::<(), hysteron_rig::Error>(())
//! ```

mod chain;
mod fault;
mod files;
mod gripper;
mod handling;
mod leader;
mod nad;
#[cfg(unix)]
mod ports;
mod robot;
mod schema;
mod servo;
mod stiction;
mod task;
mod telemetry;
#[cfg(test)]
mod tests;
mod trajectory;
mod world;

pub use chain::{ArmBody, ArmLink, BodyChain, Configuration, N_JOINTS};
pub use fault::JointFault;
pub use gripper::VirtualGripper;
pub use handling::{ArmControl, Moment};
pub use leader::{Posture, VirtualLeader};
pub use nad::{Planned, SPLITS, data_set, fault_set};
#[cfg(unix)]
pub use ports::{HeldLeader, VirtualFollower};
pub use robot::{ArmVariation, Supply, TelemetryNoise, VirtualArm, VirtualForceSensor};
pub use servo::{GearFriction, ServoState, VirtualServo, WindingHeat};
pub use task::{ArmCourse, ArmTask, ArmTrial, Degraded, Labels, PushDirection, PushProfile};
pub use telemetry::{Reading, TelemetryRecorder};
pub use world::{AppliedTorques, ArmWorld, N_SERVOS, Object};
