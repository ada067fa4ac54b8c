//! A run: a robot goes through the samples of a recording, from files to files.
//!
//! Partial results never have the final name. A run that fails or is interrupted leaves its rows as
//! `<out>.partial.<ext>` with the last equilibrium next to it as `<out>.state`, from which `--resume` continues. What
//! the robot does in a sample is the one difference between the verbs: it follows strokes, or reaches for a goal.

mod band;
mod exact;
mod figures;
mod in_memory;
mod input;
mod options;
mod outcome;
mod page;
mod partial;
mod residual;
mod rollout;
#[expect(clippy::module_inception, reason = "the recipe of a room is in run.rs")]
mod run;
mod series;
mod summary;
mod trace;

pub use band::{TIP_BAND, expected_within};
pub use in_memory::rollout;
pub use input::Task;
pub use options::RunOptions;
pub use outcome::Outcome;
pub use run::run;
