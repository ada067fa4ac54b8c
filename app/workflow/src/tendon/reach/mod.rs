//! `hysteron reach`: the strokes that bring the tip to recorded goals, sample by sample.

mod options;
mod run;

pub use crate::shared::run::Outcome;
pub use options::Options;
pub use run::run;
