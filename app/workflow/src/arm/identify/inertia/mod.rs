//! `hysteron arm identify inertia`: bodies, rotors and friction of all joints.

mod options;
mod outcome;
mod page;
mod run;

pub use options::Options;
pub use outcome::{Outcome, ResponseEstimate};
pub use run::run;
