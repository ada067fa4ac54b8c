//! `hysteron arm record`: a follower follows the leader that a person moves, and is recorded.

mod options;
mod outcome;
mod run;

pub use options::Options;
pub use outcome::Outcome;
pub use run::run;
pub(super) use run::{record, summary};
