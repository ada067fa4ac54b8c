//! `study sensing`: force estimation without force sensors. Tensions and pushes estimated from recordings of virtual robots,
//! whose true forces are known.
//!
//! Each robot is calibrated from recordings of its own, as a user would; the scale of its servos' loads from one whose tensions are known;
//! the sensor is fitted on further ones, and evaluated on others.

mod outcome;
mod page;
mod recordings;
mod run;

pub use outcome::{SensedRobot, SensingMetrics, WithoutContact};
pub use run::run;
