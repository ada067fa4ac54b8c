//! `study inverse`: the inverse network on robots that other people recorded. Which strokes, or motor angles, made a given path
//! of the tip?
//!
//! Compared with baselines without a network: a static regression, the same of the tip some time later, and a
//! kernel on two tips, with the delay that does best on the validation trajectories; and the same network
//! without looking ahead. The last method is what `train` would write: static regression, kernel regression or network, chosen by
//! demonstrations left out in folds and then fitted to all of them. On the trunk, blocks of the run take turns: most for training, some for validation,
//! some for the test; and the same blocks of a run with a load at the tip. On the three-segment robot whole
//! patterns, in five folds.

mod baselines;
mod demonstrations;
mod methods;
mod outcome;
mod page;
mod run;

pub use outcome::{InverseMetrics, PathDifference, SegmentsResult, TrunkResult};
pub use run::run;
