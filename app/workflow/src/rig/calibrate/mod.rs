//! `hysteron rig calibrate`: zero, slack and pretension of every tendon, and the tracker's frame.

mod options;
mod outcome;
mod run;

pub use options::Options;
pub use outcome::{ChannelCalibration, Outcome};
pub use run::run;
