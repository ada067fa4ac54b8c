//! `hysteron reduce`: a scene's body as a chain of condensed sections, checked against its finite elements.

mod options;
mod outcome;
mod run;

pub use options::Options;
pub use outcome::Outcome;
pub use run::run;
