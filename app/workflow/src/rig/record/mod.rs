//! `hysteron record`: a plan becomes recordings.

pub mod jobs;
mod live;
mod options;
mod outcome;
mod page;
pub mod partial_files;
mod run;
mod simulated;
pub mod source;
mod summary;
mod tip_force;

pub use options::Options;
pub use outcome::Outcome;
pub use run::run;
pub use summary::RecordedTrajectory;
