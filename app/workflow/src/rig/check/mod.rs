//! `hysteron rig check`: who is on the bus, and is it fit to run?

mod options;
mod outcome;
mod run;

pub use options::Options;
pub use outcome::{Outcome, Port, ServoSummary};
pub use run::run;
