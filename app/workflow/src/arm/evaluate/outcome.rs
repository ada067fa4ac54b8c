//! The outcome of `arm evaluate`: of a neural actuator, or of a model of inverse dynamics.

use hysteron_arm_learning::neural::{
    ActuatorComparison, ByHorizon, ByMethod, ComparisonFormat, DetectorScores, ForceSource, ForcesBySource,
    TaskScores,
};
use hysteron_base::checks::Warning;
use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize};

use crate::shared::outcome;
use crate::{COMMIT, Context};

/// The outcome of `arm evaluate`: of a neural actuator, or of a model of inverse dynamics.
#[derive(Debug, Clone, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum Outcome {
    /// Of a neural actuator.
    Actuator(Box<ActuatorEvaluation>),
    /// Of a model of inverse dynamics.
    InverseDynamics(DynamicsScores),
}

impl outcome::Outcome for Outcome {}

impl<'de> Deserialize<'de> for Outcome {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let actuator = |found| Self::Actuator(Box::new(found));
        outcome::by_key(deserializer, "tasks", actuator, Self::InverseDynamics)
    }
}

/// Errors of a model of inverse dynamics on a recording.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct DynamicsScores {
    /// Mean squared error of the torque, joint by joint [N² m² or N²].
    pub mse_n2_m2: Vec<f64>,
    /// The same over the variance of the torque [-].
    pub nmse: Vec<f64>,
    /// Coefficient of determination of all joints together [-].
    pub pooled_r2: f64,
    /// Mean of the joints' coefficients of determination [-].
    pub mean_r2: f64,
    /// Warnings about the recordings.
    #[serde(default)]
    pub recording_warnings: Vec<Warning>,
}

/// Comparison of a neural actuator with its baselines.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct ActuatorEvaluation {
    /// Format of the file.
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
    /// Accuracy and area under the curve of the condition, sample by sample; none unless both conditions are there.
    pub condition_accuracy_auc: Option<[f64; 2]>,
    /// One entry per task.
    pub tasks: Vec<TaskScores>,
    /// Criterion by which recordings were excluded from the training; none where that is not known.
    pub left_out: Option<Vec<String>>,
    /// Number of recordings that it was trained on.
    pub trained_on: usize,
    /// Detectors of a degraded motor, where recordings to fit them to were given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub detectors: Option<Vec<DetectorScores>>,
    /// Warnings about the recordings.
    #[serde(default)]
    pub recording_warnings: Vec<Warning>,
    /// Joints that `--fix-base` holds at zero.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub held_joints: Vec<String>,
    /// The command that made this.
    pub command: String,
    /// Commit of the program.
    pub commit: String,
}

impl ActuatorEvaluation {
    /// Of a comparison.
    pub(super) fn new(
        comparison: ActuatorComparison,
        detectors: Option<Vec<DetectorScores>>,
        (recording_warnings, held_joints): (Vec<Warning>, Vec<String>),
        context: &Context,
    ) -> Self {
        let ActuatorComparison { format, version, mean_deg, mean_gripper_mm, .. } = comparison;
        let ActuatorComparison { forces, force_from, condition_accuracy_auc, .. } = comparison;
        Self {
            format,
            version,
            mean_deg,
            mean_gripper_mm,
            forces,
            force_from,
            condition_accuracy_auc,
            tasks: comparison.tasks,
            left_out: comparison.left_out,
            trained_on: comparison.trained_on,
            detectors,
            recording_warnings,
            held_joints,
            command: context.command.clone(),
            commit: COMMIT.to_owned(),
        }
    }
}
