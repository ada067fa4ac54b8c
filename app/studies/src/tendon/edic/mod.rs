//! `study edic`: open-loop tracking of ideal paths (CoReAct paper, tables II to IV). Strokes found by one method or another,
//! carried out on the virtual rig without a sensor, and measured.
//!
//! The ablation: the fitted twin without learning; an inverse network on recorded data; the paper's network,
//! ours on recorded and synthetic data; and the calibrated twin, steered. One calibrated twin makes the data
//! of all seeds of networks. No path is in any training.

mod outcome;
mod page;
mod run;

pub use outcome::{EdicMetrics, EdicPath, MethodRuns};
pub use run::run;
