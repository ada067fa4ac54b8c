//! `hysteron arm emulate`: the virtual arm and its leader on ports, for any program that speaks to the real ones.

mod options;
mod outcome;
mod run;

pub use options::Options;
pub use outcome::{Outcome, PortCounts};
pub use run::run;
