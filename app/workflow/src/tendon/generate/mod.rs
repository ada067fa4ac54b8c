//! `hysteron generate`: a plan carried out by the calibrated twin, as data to learn from.

mod options;
mod outcome;
mod page;
mod range;
mod rollout;
mod run;
mod shard;
mod steer;

pub use options::Options;
pub(crate) use outcome::tip_of;
pub use outcome::{Outcome, Scaled, SyntheticTrajectory};
pub use range::CalibratedRange;
pub(crate) use rollout::{TrajectorySimulator, reason};
pub(crate) use run::default_plan;
pub use run::run;
pub use shard::Shard;
