//! `hysteron arm dynamics`: every quantity of rigid-body dynamics, for every row of states.

mod options;
mod outcome;
mod run;

pub use options::Options;
pub use outcome::Outcome;
pub use run::run;
