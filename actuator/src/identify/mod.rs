//! Drives by rollout, open loop from the first sample on; laws of friction by regression.

mod friction;
mod pendulum;
mod servo;

pub use friction::{FrictionFit, identify_friction};
pub use pendulum::{Pendulum, PendulumRun, Rollout, rollout};
pub use servo::{DriveFit, DriveFitOptions, DriveQuantity, QUANTITIES, identify_drive, mean_error};
