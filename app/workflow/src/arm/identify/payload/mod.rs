//! `hysteron arm identify payload`: what an arm carries.

mod options;
mod outcome;
mod page;
mod run;

pub use options::Options;
pub use outcome::Outcome;
pub use run::run;
