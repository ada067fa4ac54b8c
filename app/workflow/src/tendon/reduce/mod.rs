//! `hysteron reduce`: the body of a robot as a chain of condensed sections, compared with its mesh.

mod equilibria;
mod options;
mod outcome;
mod run;

pub use options::Options;
pub use outcome::Outcome;
pub use run::run;
