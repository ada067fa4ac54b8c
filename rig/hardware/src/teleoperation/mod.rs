//! Two arms: a person moves the leader, the follower follows, and is recorded.
//!
//! The leader's servos have no torque and are only read. The follower is a robot under torque, for which the rules of a rig
//! hold: nothing moves beyond a limit, every way out ends with its torque off, and what was recorded is kept.

mod arms;
mod config;
mod recording;
mod schema;
mod session;

pub use arms::ArmPair;
pub use config::{ArmLimits, ArmsConfig, GripperConfig, JointConfig, ServoMount};
pub use recording::{Append, ArmsOutcome, ArmsRecording, Estimates, channel_names};

/// The arms of OpenManipulator-X, as the virtual arm emulates them: a file to copy.
pub const ARMS_FILE: &str = include_str!("../../presets/arms.toml");
