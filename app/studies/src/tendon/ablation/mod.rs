//! `study ablation`: the effect of each part of the chain on other robots, the presets, and members of the population around
//! `typical`.
//!
//! Every robot is known from a minute of recordings alone (the plan `quick`). The ablation levels: strokes
//! through the twin without learning; an inverse network on the minute; the paper's and ours on the minute
//! and on data of the calibrated twin; the calibrated twin, steered; and that twin after it has been adapted
//! to one path more while its tip was measured. The scene is that of `typical` for all: the difference of a
//! robot is left to learning. No path is in any training.

mod outcome;
mod page;
mod run;

pub use outcome::{AblatedRobot, AblationMetrics, AblationPath, LevelResult};
pub use run::run;
