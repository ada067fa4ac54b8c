//! `hysteron generate`: a plan carried out by the calibrated twin, as data to learn from.

mod options;
mod outcome;
mod page;
mod range;
mod run;
mod shard;
mod steer;

pub use options::Options;
pub use outcome::{Outcome, Scaled, SyntheticTrajectory};
pub use range::CalibratedRange;
pub use run::run;
pub use shard::Shard;
