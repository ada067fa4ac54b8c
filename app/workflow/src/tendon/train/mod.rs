//! `hysteron train`: the inverse controller, from recordings of a rig and of a twin.

mod compared;
mod judge;
mod leading_twin;
mod options;
mod outcome;
mod page;
mod run;

pub use compared::{CandidateErrors, SAME};
pub use options::{ControllerName, FOLDS, Options, Weights};
pub use outcome::Outcome;
pub use run::run;
