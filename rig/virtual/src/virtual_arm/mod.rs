//! The virtual arm: a follower of four joints with a gripper, its servos, what it carries and what pushes it.
//!
//! It stands in for the arm of the data set NAD. Its bodies, gears and motors are written for it alone and share neither code nor
//! parameters with the estimators of `hysteron-arm-estimation`, which are tried on it. The equations stand in `docs/virtual-arm.md`.
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

pub use chain::{Body, Chain, Configuration, Link, N_JOINTS};
pub use fault::Fault;
pub use gripper::Gripper;
pub use handling::{Control, Moment};
pub use leader::{Leader, Posture};
pub use nad::{Planned, SPLITS, data_set, fault_set};
#[cfg(unix)]
pub use ports::{Follower, HeldLeader};
pub use robot::{ForceSensor, Spread, Supply, Telemetry, VirtualArm};
pub use servo::{GearFriction, Heat, Servo, ServoState};
pub use task::{Course, Degraded, Direction, Labels, Press, Task, Trial};
pub use telemetry::{Reading, Recorder};
pub use world::{Acted, ArmWorld, N_SERVOS, Object};
