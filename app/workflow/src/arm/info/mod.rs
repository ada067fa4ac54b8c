//! `hysteron arm info` and `hysteron arm check`.

mod options;
mod outcome;
mod run;

pub use options::{CheckOptions, Options};
pub use outcome::{JointSummary, Outcome};
pub use run::{check, run};
