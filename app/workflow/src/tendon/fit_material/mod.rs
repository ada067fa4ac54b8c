//! `hysteron fit-material`: the physical parameters of a scene from recordings of its robot.

mod options;
mod outcome;
mod page;
mod quantities;
mod run;
mod scene_file;
mod verdict;

pub use options::{FrameChoice, MAX_STEPS, Options};
pub use outcome::{FittedParameter, FittedTipErrors, Outcome};
pub use run::run;
