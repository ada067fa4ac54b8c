//! Drives by rollout, open loop from the first sample on; laws of friction by regression and by other methods.

mod dahl_map;
mod friction;
mod lost_motion;
mod methods;
mod pendulum;
mod pulley;
mod servo;

pub use dahl_map::{DahlMap, FrictionRun, RIPPLE_TERMS, TERMS};
pub use friction::{FrictionFit, identify_friction};
pub use lost_motion::{LostMotion, lost_motion};
pub use methods::{FrictionMethod, MethodFit, identify_friction_by};
pub use pendulum::{Pendulum, PendulumRollout, PendulumRun, rollout};
pub use pulley::{
    Backlash, PulleyFit, PulleyRecord, PulleyServo, Reversal, SlackFriction, SteadySamples, find_slack,
    finest_speed, identify_backlash, identify_pulley, slack_friction,
};
pub use servo::{DriveFit, DriveFitOptions, DriveQuantity, QUANTITIES, identify_drive, mean_error};
