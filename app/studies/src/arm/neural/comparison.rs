//! Cells of the study: what was found of an actuator of one seed, and of the detectors of a degraded motor.

use hysteron_arm_learning::neural::{
    ActuatorComparison, ByHorizon, ByMethod, ComparisonFormat, DetectorScores, ForceSource, ForcesBySource,
    TaskScores, TaskTrace,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// An actuator of one seed compared with its baselines on the test tasks of a split.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct NeuralCell {
    /// Format of the comparison.
    pub format: ComparisonFormat,
    /// Its version.
    pub version: u32,
    /// Mean absolute error of the joints over the first steps of rollouts, mean of the tasks [deg].
    pub mean_deg: ByMethod<ByHorizon<Option<f64>>>,
    /// The same of the aperture [mm]; none without a gripper.
    pub mean_gripper_mm: ByMethod<ByHorizon<Option<f64>>>,
    /// Errors of the forces, all tasks together.
    pub forces: ForcesBySource,
    /// Network that gives the force.
    pub force_from: ForceSource,
    /// Accuracy and area under the curve of the condition, sample by sample [-]; none unless both conditions are there.
    pub condition_accuracy_auc: Option<[f64; 2]>,
    /// One entry per task.
    pub tasks: Vec<TaskScores>,
    /// Criterion by which recordings were excluded from the training; none where that is not known.
    pub left_out: Option<Vec<String>>,
    /// Number of trajectories that it was trained on.
    pub trained_on: usize,
    /// Root mean square error of the joints in rollouts of the validation trajectories [deg].
    pub validation_deg: f64,
    /// Number of parameters of the network in the loop.
    pub parameters: usize,
    /// Detectors of a degraded motor; none without a network of force and condition, or where a condition is missing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub detectors: Option<Vec<DetectorScores>>,
    /// Trajectories for figures, of the first seed alone; null for a task that is not there.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub traces: Option<Vec<Option<TaskTrace>>>,
    /// Gradients of the loss by horizon, of the first seed alone; none without trajectories that are long enough.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gradients: Option<Vec<HorizonGradient>>,
}

impl NeuralCell {
    /// Of a comparison, with the error on the validation trajectories [deg], and the numbers of parameters and of training
    /// trajectories.
    pub(super) fn new(
        comparison: ActuatorComparison,
        validation_deg: f64,
        [parameters, trained_on]: [usize; 2],
    ) -> Self {
        let ActuatorComparison { format, version, mean_deg, mean_gripper_mm, .. } = comparison;
        let ActuatorComparison { forces, force_from, condition_accuracy_auc, tasks, left_out, .. } =
            comparison;
        Self {
            format,
            version,
            mean_deg,
            mean_gripper_mm,
            forces,
            force_from,
            condition_accuracy_auc,
            tasks,
            left_out,
            trained_on,
            validation_deg,
            parameters,
            detectors: None,
            traces: None,
            gradients: None,
        }
    }

    /// Scores of the task of this name.
    pub(super) fn task(&self, name: &str) -> Option<&TaskScores> {
        self.tasks.iter().find(|task| task.task == name)
    }
}

/// Gradient of the loss over a horizon, mean of the rollouts.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct HorizonGradient {
    /// The horizon [steps].
    pub steps: usize,
    /// Mean size of the gradient by the torque of a step [1/(N m)].
    pub by_torque: f64,
    /// Size of the gradient by the weights [-].
    pub by_weights: f64,
    /// Cosine of the gradient by the weights with that of 128 steps [-].
    pub cosine: f64,
}

/// Detectors of a degraded motor on faults that the published data set does not have.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct FaultCell {
    /// Number of trajectories that the network was trained on.
    pub trained_on: usize,
    /// Number of trajectories that detectors were tested on.
    pub tests: usize,
    /// The detectors by kind of fault.
    pub detectors: FaultDetectors,
}

/// Detectors of a degraded motor by kind of fault, each next to healthy motors.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct FaultDetectors {
    /// On motors with a rubber band.
    pub band: Vec<DetectorScores>,
    /// On motors with more dry friction.
    pub friction: Vec<DetectorScores>,
    /// On motors with a lost tooth.
    pub lost_tooth: Vec<DetectorScores>,
    /// On all of them.
    pub all: Vec<DetectorScores>,
}

impl FaultDetectors {
    /// In the order of [`super::KINDS`], then of all faults.
    pub fn values(&self) -> [&[DetectorScores]; 4] {
        [&self.band, &self.friction, &self.lost_tooth, &self.all].map(Vec::as_slice)
    }
}
