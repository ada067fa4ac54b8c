//! `hysteron identify`: recordings become strokes of auxiliary tendons.

mod options;
mod outcome;
mod page;
mod run;

pub use options::{MAX_ROUNDS, Options};
pub use outcome::{IdentifiedRecording, Outcome};
pub use run::run;
