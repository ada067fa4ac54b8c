//! `hysteron target`: a path for the tip, sampled; and whether a robot reaches it.

mod options;
mod outcome;
mod page;
mod reach;
mod run;

pub use options::Options;
pub use outcome::Outcome;
pub use reach::Reach;
pub use run::run;
