//! The virtual rig: a robot with physics of its own, its servos and its tracker.
//!
//! Its body is an elastic rod with tendons that rub, stick and go slack; it is not the twin, and shares no code with it.

mod body;
mod equilibrium;
mod linear;
mod loops;
mod robot;
mod section;
mod sensor;
#[cfg(test)]
mod tests;
mod typed;
mod world;

pub use loops::{LoopWidth, loop_width};
pub use robot::{BodyParameters, ServoParameters, Spread, TendonParameters, TrackerParameters, VirtualRobot};
pub use world::{BalanceCounts, Energy, TrackedPose, World};
