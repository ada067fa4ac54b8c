//! `hysteron check`: is a scene fit to be simulated, and what will it cost? Can recordings be true?

mod options;
mod outcome;
mod recordings;
mod refused;
mod run;
mod scene;

pub use options::Options;
pub use outcome::{Described, Outcome, RecordingFindings, SceneSummary};
pub use refused::Refused;
pub use run::run;
