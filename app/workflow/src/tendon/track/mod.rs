//! `hysteron track`: a path, its strokes, the rig, and how closely the tip followed; open loop.

mod feedback;
mod learning;
mod options;
mod outcome;
mod run;

pub use options::Options;
pub use outcome::{Outcome, Recorded};
pub use run::run;
