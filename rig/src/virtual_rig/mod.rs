//! The virtual rig: a robot with physics of its own, its servos and its tracker.
//!
//! Its body is an elastic rod with tendons that rub, stick and go slack; it is not the twin, and shares no code with it.

mod body;
mod equilibrium;
mod linear;
mod section;
#[cfg(test)]
mod tests;
mod world;

pub use world::{TrackedPose, World};
