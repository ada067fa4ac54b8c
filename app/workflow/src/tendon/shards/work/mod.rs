//! `hysteron shards work`: shards of a set, made until none is missing.

mod options;
mod outcome;
mod run;

pub use options::Options;
pub use outcome::Outcome;
pub use run::run;
