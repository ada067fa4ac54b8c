//! Drives identified from what they did: by rollout, open loop from the first sample on.

mod pendulum;
mod servo;

pub use pendulum::{Pendulum, PendulumRun, Rollout, rollout};
pub use servo::{DriveFit, DriveFitOptions, DriveQuantity, QUANTITIES, identify_drive, mean_error};
