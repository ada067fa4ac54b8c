//! `study population`: the whole chain on robots of a wide population, `virtual:wide/1` to `virtual:wide/10`, each known from
//! its recordings alone.
//!
//! One procedure for all, no hand on any: record a plan of minutes; fit the nominal scene; calibrate the twin in two
//! passes; let it make data; train inverse networks; follow seven paths that are in no training. What was
//! done for a robot stays in its folder: the same command resumes. A robot on which a stage fails is counted
//! and named.

mod outcome;
mod page;
mod plans;
mod run;

pub use outcome::{PopulationMetrics, PopulationPath, PopulationRobot};
pub(super) use plans::write_recorded_plan;
pub use run::run;
