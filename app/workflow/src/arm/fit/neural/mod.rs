//! `hysteron arm fit neural`: an actuator from telemetry alone.

mod data;
mod options;
mod outcome;
mod run;

pub use options::{Options, SensingForm, block, form, prior, sensing};
pub use outcome::Outcome;
pub use run::run;
