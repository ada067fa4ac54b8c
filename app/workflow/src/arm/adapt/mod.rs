//! `hysteron arm adapt`: a neural actuator for an arm that has changed, from a few trajectories.

mod options;
mod outcome;
mod run;

pub use options::Options;
pub use outcome::Outcome;
pub use run::run;
