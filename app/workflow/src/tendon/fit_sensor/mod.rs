//! `hysteron fit-sensor`: what a robot's forces can be told from, learned from motion without contact.

mod options;
mod outcome;
mod run;

pub use options::Options;
pub use outcome::Outcome;
pub use run::run;
