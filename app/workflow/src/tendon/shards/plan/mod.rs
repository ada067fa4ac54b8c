//! `hysteron shards plan`: a set of data described, with all that its workers need.

mod estimate;
mod options;
mod outcome;
mod run;

pub use estimate::CostEstimate;
pub use options::Options;
pub use outcome::{Outcome, PlannedInput};
pub use run::run;
