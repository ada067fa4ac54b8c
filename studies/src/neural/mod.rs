//! Actuators learned from telemetry, beside what Dou et al. (NeuralActuator) print and beside simple rivals: `arm study neural`.
//!
//! Cells: the published split and one without a payload, seed by seed; a condition at a payload that was not seen; networks in the loop;
//! faults of a motor that the published data set does not have.

mod cells;
mod faults;
mod gradients;
pub mod published;
mod run;
#[cfg(test)]
#[path = "../../../arm/src/neural/test_motion.rs"]
mod test_motion;
#[cfg(test)]
mod tests;

pub use cells::{FAULTS, LEFT_OUT, NETWORKS, NetworkKind, NeuralScope, NeuralSize};
pub use faults::{FAULT_SPLITS, KINDS};
pub use run::{NeuralStudy, neural_study};

use hysteron_arm::neural::{Features, Trajectory};

/// What a recording is for in a data set.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Split {
    /// To learn from.
    Training,
    /// To keep what does best.
    Validation,
    /// To compare with.
    Test,
}

/// A trajectory of a data set.
#[derive(Debug, Clone)]
pub struct Sample {
    /// Folders of subset and task: `weight/pick_place_object_500g`.
    pub task: String,
    /// What it is for.
    pub split: Split,
    /// The trajectory.
    pub trajectory: Trajectory,
}

/// Trajectories of one arm, in the folders of NAD.
#[derive(Debug, Clone)]
pub struct NeuralData {
    /// What a sample has.
    pub features: Features,
    /// Time from sample to sample [s].
    pub period: f64,
    /// All trajectories.
    pub samples: Vec<Sample>,
}
