//! `study wrist`: interaction torques of the simulated wrist exoskeleton of Saadatzi et al. (2019).

mod cells;
mod options;
mod outcome;
mod page;
mod run;

pub use cells::{DRIFTS, WristStudy, wrist_study};
pub use options::Options;
pub use outcome::Outcome;
pub use run::run;
