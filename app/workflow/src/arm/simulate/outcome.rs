//! The outcome of `arm simulate`: how far and how fast each joint went, and the energy.

use hysteron_arm_dynamics::Model;
use hysteron_arm_estimation::{JointQuantityKind, channel_name};
use hysteron_base::Recording;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::arm::robot::held_joints;
use crate::shared::outcome::{self, MetricsFormat};

/// The outcome of `arm simulate`.
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
    /// One entry per joint.
    pub joints: Vec<JointMotionRange>,
    /// Energy at the start and at the end [J].
    pub energy_j: [f64; 2],
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
    /// Of a simulated motion.
    pub(super) fn new(model: &Model, motion: &Recording) -> anyhow::Result<Self> {
        let (meta, time, total) = (motion.meta(), motion.time(), total_energy(motion)?);
        Ok(Self {
            format: MetricsFormat,
            version: 1,
            robot: model.name().to_owned(),
            samples: time.len(),
            duration_s: time[time.len() - 1] - time[0],
            joints: ends(model, motion)?,
            energy_j: [total[0], total[total.len() - 1]],
            held_joints: held_joints(model),
            command: meta.command.clone(),
            commit: meta.commit.clone(),
        })
    }
}

/// Kinetic and potential energy together [J].
pub(super) fn total_energy(motion: &Recording) -> anyhow::Result<Vec<f64>> {
    let [kinetic, potential] = ["kinetic_energy_j", "potential_energy_j"].map(|name| motion.require(name));
    Ok(kinetic?.iter().zip(potential?).map(|(a, b)| a + b).collect())
}

/// How far and how fast a joint went, in its unit.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct JointMotionRange {
    /// Name of the joint.
    pub name: String,
    /// Smallest coordinate [rad or m].
    pub least: f64,
    /// Largest coordinate [rad or m].
    pub most: f64,
    /// Largest speed [rad/s or m/s].
    pub fastest: f64,
}

fn ends(model: &Model, motion: &Recording) -> anyhow::Result<Vec<JointMotionRange>> {
    let end = |(k, joint): (usize, &hysteron_arm_dynamics::Joint)| {
        let of = |quantity| motion.require(&channel_name(model, quantity, k));
        let (q, dq) = (of(JointQuantityKind::Position)?, of(JointQuantityKind::Velocity)?);
        Ok(JointMotionRange {
            name: joint.name.clone(),
            least: q.iter().copied().fold(f64::INFINITY, f64::min),
            most: q.iter().copied().fold(f64::NEG_INFINITY, f64::max),
            fastest: dq.iter().fold(0.0, |most, speed| f64::max(most, speed.abs())),
        })
    };
    model.joints().iter().enumerate().map(end).collect()
}
