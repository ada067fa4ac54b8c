//! `hysteron sense`: tensions and the force on the tip of a recorded robot, without a sensor for either.

pub(crate) mod file;
pub(crate) mod input;
pub mod live;
mod options;
mod outcome;
mod page;
mod run;
mod scores;

pub use options::Options;
pub use outcome::{ContactScore, ForceScore, Outcome, SensingScores, TensionScore};
pub use run::run;
