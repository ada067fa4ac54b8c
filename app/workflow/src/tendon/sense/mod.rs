//! `hysteron sense`: tensions and the force on the tip of a recorded robot, without a sensor for either.

pub(crate) mod file;
pub(crate) mod input;
pub mod live;
mod options;
mod outcome;
mod page;
mod run;

pub use options::Options;
pub use outcome::Outcome;
pub use run::run;
