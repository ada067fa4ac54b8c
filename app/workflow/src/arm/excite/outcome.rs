//! The outcome of `arm excite`: a designed motion, and how well it shows the parameters of the arm.

use hysteron_arm_dynamics::Model;
use hysteron_arm_estimation::Excitation;
use hysteron_base::Recording;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::arm::robot::held_joints;
use crate::shared::outcome::{self, MetricsFormat};

/// The outcome of `arm excite`.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Outcome {
    /// Format of the file.
    pub format: MetricsFormat,
    /// Its version.
    pub version: u32,
    /// Name of the robot.
    pub robot: String,
    /// Number of samples.
    pub samples: usize,
    /// Time from the first to the last sample [s].
    pub duration_s: f64,
    /// Parameters that torques can identify; none without a search.
    pub base_parameters: Option<usize>,
    /// Condition number of their regressor [-]; none without a search.
    pub condition_number: Option<f64>,
    /// The same of a drawn series within the limits [-].
    pub condition_number_before: Option<f64>,
    /// Seed of the search; none without one.
    pub seed: Option<u64>,
    /// Joints that `--fix-base` holds at zero.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub held_joints: Vec<String>,
    /// The command that made this.
    pub command: String,
    /// Commit of the program.
    pub commit: String,
}

impl outcome::Outcome for Outcome {}

impl Outcome {
    /// Of a designed motion, and of the search that found it.
    pub(super) fn new(model: &Model, states: &Recording, found: Option<&Excitation>) -> Self {
        let (meta, time) = (states.meta(), states.time());
        Self {
            format: MetricsFormat,
            version: 1,
            robot: model.name().to_owned(),
            samples: time.len(),
            duration_s: time[time.len() - 1] - time[0],
            base_parameters: found.map(|found| found.n_parameters),
            condition_number: found.map(|found| found.condition),
            condition_number_before: found.map(|found| found.condition_before),
            seed: meta.seed,
            held_joints: held_joints(model),
            command: meta.command.clone(),
            commit: meta.commit.clone(),
        }
    }
}
