//! `hysteron target`: a path for the tip, sampled; and whether a robot reaches it.

mod options;
mod outcome;
mod page;
mod run;

pub use options::Options;
pub use outcome::Outcome;
pub use run::run;
