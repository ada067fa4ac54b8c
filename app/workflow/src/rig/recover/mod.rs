//! `hysteron rig recover`: from the journal of a run that crashed to its recording.

mod options;
mod outcome;
mod run;

pub use options::Options;
pub use outcome::Outcome;
pub use run::run;
