//! The outcome of `arm info` and `arm check`: the joints of a robot in numbers.

use hysteron_arm_dynamics::Model;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::arm::robot::held_joints;
use crate::shared::outcome;

/// The outcome of `arm info` and of `arm check`.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Outcome {
    /// Name of the robot.
    pub robot: String,
    /// Joints that move.
    pub joints: Vec<JointSummary>,
    /// Distance from the base that no point of the robot is beyond [m].
    pub reach_m: f64,
    /// Joints that are held at zero.
    pub held_joints: Vec<String>,
    /// Warnings about the file, as sentences.
    pub warnings: Vec<String>,
}

impl outcome::Outcome for Outcome {}

/// A joint in numbers.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct JointSummary {
    /// Name.
    pub name: String,
    /// Mass of what moves with it and with no later joint [kg].
    pub mass_kg: f64,
    /// Smallest and largest coordinate [rad or m]; none where the file has no limits.
    pub range: Option<[f64; 2]>,
}

impl Outcome {
    pub(super) fn new(model: &Model) -> Self {
        let joints = model.joints().iter().map(|joint| JointSummary {
            name: joint.name.clone(),
            mass_kg: joint.inertia.mass,
            range: joint.drive.range,
        });
        Self {
            robot: model.name().to_owned(),
            joints: joints.collect(),
            reach_m: model.reach(),
            held_joints: held_joints(model),
            warnings: model.notes().warnings.clone(),
        }
    }
}
