//! `hysteron fit-residual`: the network that makes the twin show the robot's hysteresis.

mod options;
mod outcome;
mod page;
mod run;

pub use options::{MAX_MEMBERS, Options};
pub use outcome::Outcome;
pub use run::run;
