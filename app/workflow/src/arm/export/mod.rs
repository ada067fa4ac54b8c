//! `hysteron arm export`: a robot as a file for other programs.

mod options;
mod outcome;
mod run;

pub use options::Options;
pub use outcome::Outcome;
pub use run::run;
