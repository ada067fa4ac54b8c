//! `hysteron fit-sensor`: a force sensor of a robot, learned from motion without contact.

mod options;
mod outcome;
mod run;

pub use options::Options;
pub use outcome::Outcome;
pub use run::run;
