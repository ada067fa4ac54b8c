//! The outcome of `arm generate`: the card of a data set.

use hysteron_base::Recording;
use hysteron_virtual_rig::virtual_arm::{Planned, VirtualArm};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::shared::outcome::{self, MetricsFormat};
use crate::{COMMIT, Context};

/// Introduction on every page of the data set.
const ABOUT: &str = "Virtual arm in place of NAD: simulated with the tasks, channels, rates and quantisation of that data set, not \
                     measured on a robot. Channels truth_* are known to the simulation alone and are no inputs.";

/// The outcome of `arm generate`.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Outcome {
    /// Format of the file.
    pub format: MetricsFormat,
    /// Its version.
    pub version: u32,
    /// Description of the data set, with its limits.
    pub about: String,
    /// Name of the virtual arm.
    pub arm: String,
    /// SHA-256 of its file.
    pub arm_sha256: String,
    /// Seed of the individual arm, its motions and its noise.
    pub seed: u64,
    /// Number of trajectories.
    pub trajectories: usize,
    /// Samples of all.
    pub samples: usize,
    /// Duration of all [min].
    pub duration_min: f64,
    /// One entry per trajectory.
    pub rows: Vec<ArmTrajectory>,
    /// The command that made this.
    pub command: String,
    /// Commit of the program.
    pub commit: String,
}

impl outcome::Outcome for Outcome {}

impl Outcome {
    /// Of all trajectories of a data set.
    pub(super) fn new(arm: &VirtualArm, seed: u64, rows: Vec<ArmTrajectory>, context: &Context) -> Self {
        let seconds: f64 = rows.iter().map(|row| row.duration_s).sum();
        Self {
            format: MetricsFormat,
            version: 1,
            about: ABOUT.to_owned(),
            arm: arm.name.clone(),
            arm_sha256: arm.hash.clone(),
            seed,
            trajectories: rows.len(),
            samples: rows.iter().map(|row| row.samples).sum(),
            duration_min: seconds / 60.0,
            rows,
            command: context.command.clone(),
            commit: COMMIT.to_owned(),
        }
    }
}

/// A trajectory of the virtual arm.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct ArmTrajectory {
    /// Subset, task, split and number.
    pub name: String,
    /// Number of samples.
    pub samples: usize,
    /// Time of the last sample [s].
    pub duration_s: f64,
    /// Part of the samples whose force is labelled [-].
    pub labelled: f64,
    /// Condition of the motors.
    pub condition: String,
    /// Mass that the arm carries [kg].
    pub payload_kg: f64,
}

impl ArmTrajectory {
    /// Of a trajectory as it was recorded.
    pub(super) fn new(planned: &Planned, recording: &Recording) -> Self {
        let n = recording.n_samples();
        let labelled = recording.channel("force_z_labelled_ratio").unwrap_or(&[]);
        Self {
            name: planned.name(),
            samples: n,
            duration_s: recording.time()[n - 1],
            labelled: labelled.iter().sum::<f64>() / n as f64,
            condition: recording.meta().extra.get("condition").cloned().unwrap_or_default(),
            payload_kg: planned.trial.payload,
        }
    }
}
