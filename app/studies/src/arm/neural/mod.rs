//! Learned actuators from telemetry, compared with the results of Dou et al. (NeuralActuator) and with simple
//! baselines: `study neural` and `study neural-networks`.
//!
//! Cells: the published split and one without a payload, seed by seed; a condition at a payload that is not
//! in training; networks in the loop; faults of a motor that the published data set does not have.

mod cells;
mod comparison;
mod data;
mod faults;
mod gradients;
mod options;
mod outcome;
mod page;
pub mod published;
mod run;
mod study;
#[cfg(test)]
mod tests;

pub use cells::{FAULTS, LEFT_OUT, NETWORKS, NetworkKind, NeuralScope, NeuralSize};
pub use comparison::{FaultCell, FaultDetectors, HorizonGradient, NeuralCell};
pub use faults::{FAULT_SPLITS, KINDS};
pub use options::Options;
pub use outcome::Outcome;
pub use run::run;
pub use study::{NeuralStudy, neural_study};

use hysteron_arm_learning::neural::{FeatureLayout, Trajectory};

/// Split of a data set that a recording belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Split {
    /// For the fit.
    Training,
    /// For early stopping and selection.
    Validation,
    /// For the test.
    Test,
}

/// A trajectory of a data set.
#[derive(Debug, Clone)]
pub struct Sample {
    /// Folders of subset and task: `weight/pick_place_object_500g`.
    pub task: String,
    /// Its split.
    pub split: Split,
    /// The trajectory.
    pub trajectory: Trajectory,
}

/// Trajectories of one arm, in the folders of NAD.
#[derive(Debug, Clone)]
pub struct NeuralData {
    /// Features of a sample.
    pub features: FeatureLayout,
    /// Time from sample to sample [s].
    pub period: f64,
    /// All trajectories.
    pub samples: Vec<Sample>,
}
