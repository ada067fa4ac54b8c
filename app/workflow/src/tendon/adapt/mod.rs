//! `hysteron adapt`: a calibrated twin learns, from a little of what is measured now, how its robot has changed.

mod options;
mod outcome;
mod run;

pub use options::Options;
pub use outcome::{AdaptationBlock, FoundChange, HeldOutError, Outcome};
pub use run::run;
