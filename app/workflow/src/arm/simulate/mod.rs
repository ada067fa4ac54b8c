//! `hysteron arm simulate`: the motion of an arm under recorded torques.

mod options;
mod outcome;
mod page;
mod run;

pub use options::Options;
pub use outcome::{JointMotionRange, Outcome};
pub use run::run;
