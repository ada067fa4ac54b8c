//! `hysteron simulate`: a robot follows recorded strokes, sample by sample.

mod options;
mod run;

pub use crate::shared::run::{Outcome, rollout};
pub use options::Options;
pub use run::run;
