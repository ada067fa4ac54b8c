//! `hysteron arm generate`: the data set NAD as the virtual arm records it.

mod options;
mod outcome;
mod page;
mod run;
mod selection;

pub use options::Options;
pub use outcome::{ArmTrajectory, Outcome};
pub use run::run;
