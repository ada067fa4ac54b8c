//! Reports of verbs that have no `page.rs` yet.

pub mod arm_cloning;
pub mod arm_estimation;
pub mod arm_identification;
pub mod arm_neural;
pub mod arm_study;
pub mod commands;
pub mod coverage;
pub mod study;
pub mod target;
pub mod tracking;
