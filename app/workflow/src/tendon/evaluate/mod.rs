//! `hysteron evaluate`: how closely recorded tips followed a target.

mod figures;
mod options;
mod outcome;
mod page;
mod run;
mod table;

pub use figures::{over_time, overlay};
pub use options::Options;
pub use outcome::{ComparedResult, Outcome, RecordingScore, TargetSummary};
pub use run::{rows, run, run_commanded};
pub use table::{Commanded, Row};
