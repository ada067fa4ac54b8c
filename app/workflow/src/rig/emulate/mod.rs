//! `hysteron rig emulate`: the virtual rig on ports, for any program that speaks to the real one.

mod options;
mod outcome;
mod rig_file;
mod run;

pub use options::{Options, Preset};
pub use outcome::Outcome;
pub(crate) use rig_file::PATIENT;
pub use run::run;
