//! `study robots`: the ablation of `coreact` on robots other than `typical`. The twins of other presets, trained on a third
//! of the recordings; and the twins of `typical` on members of the population around it, which were not in
//! their training.

mod outcome;
mod page;
mod run;

pub use outcome::RobotsMetrics;
pub use run::run;
