//! `hysteron import`: recordings of tendon robots and arms from the files of other programs.

mod options;
mod outcome;
mod page;
mod run;

pub use options::Options;
pub use outcome::{ChannelRange, Imported, ImportedRecording, Outcome, Proposed};
pub use run::run;
