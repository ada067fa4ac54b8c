//! The five losses: joints, gripper, force, contact gate, motor condition.

use std::ops::Range;

use hysteron_base::BadInput;
use serde::{Deserialize, Serialize};

use super::data::Trajectory;
use super::features::FeatureLayout;
use super::segment::Segment;

/// Weights of the losses and where they turn from squares to sizes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LossWeights {
    /// Of the joints' error [1/rad], squared up to `position_bend`.
    pub position: f64,
    /// Error up to which it counts by its square [rad]; zero for the paper's sizes.
    pub position_bend: f64,
    /// Of the aperture's error [1/mm].
    pub gripper: f64,
    /// Of the force's error [1/N], squared up to `force_bend`.
    pub force: f64,
    /// Error up to which it counts by its square [N].
    pub force_bend: f64,
    /// Weight of a frame under force in the force's loss (focal weight) [-].
    pub loaded: f64,
    /// Of the contact gate's cross-entropy.
    pub gate: f64,
    /// A longer force is a contact [N].
    #[serde(default = "published_contact")]
    pub contact: f64,
    /// Of the motor condition's cross-entropy.
    pub condition: f64,
}

impl LossWeights {
    /// Those of NeuralActuator's release.
    pub const PUBLISHED: Self = Self {
        position: 100.0,
        position_bend: 1.0,
        gripper: 0.02,
        force: 30.0,
        force_bend: 1.0,
        loaded: 5.0,
        gate: 1.0,
        contact: CONTACT,
        condition: 100.0,
    };

    /// Where errors of a joint turn from squares to sizes with a servo in the loop: they are some thousandths of a radian, and would weigh
    /// nothing by their squares up to the published radian [rad].
    pub const SERVO_BEND: f64 = 0.005;

    /// # Errors
    /// `BadInput` naming a weight that is negative or not finite.
    pub fn check(&self) -> Result<(), BadInput> {
        let all = [
            ("position", self.position),
            ("position_bend", self.position_bend),
            ("gripper", self.gripper),
            ("force", self.force),
            ("force_bend", self.force_bend),
            ("loaded", self.loaded),
            ("gate", self.gate),
            ("contact", self.contact),
            ("condition", self.condition),
        ];
        match all.into_iter().find(|(_, value)| !(*value >= 0.0 && value.is_finite())) {
            Some((name, value)) => Err(BadInput::new(
                format!("loss: {name}"),
                "a finite number, zero or more",
                value.to_string(),
            )),
            None => Ok(()),
        }
    }

    /// Joints and gripper of a state compared with row `target` of a trajectory; adds the gradient by the
    /// state.
    pub fn pose(
        &self,
        (trajectory, target): (&Trajectory, usize),
        features: &FeatureLayout,
        state: &[f64],
        totals: &Totals,
        gradient: &mut [f64],
    ) -> LossParts {
        let mut parts = LossParts::default();
        if trajectory.gap[target] {
            return parts;
        }
        let measured = trajectory.state_at(target);
        let n = features.joints;
        let per_joint = self.position / (totals.poses * n as f64);
        for k in 0..n {
            let (value, slope) = huber(wrap(state[k] - measured[k]), self.position_bend);
            parts.position += per_joint * value;
            gradient[k] += per_joint * slope;
        }
        if let Some(gripper) = &features.gripper {
            let error = 1e3 * gripper.slope * (state[n] - measured[n]);
            let per = self.gripper / totals.poses;
            parts.gripper += per * error.abs();
            gradient[n] += per * 1e3 * gripper.slope * sign(error);
        }
        parts
    }

    /// Force, gate and condition of the outputs at row `row` of a trajectory; adds the gradient by the outputs.
    pub fn labels(
        &self,
        (trajectory, row): (&Trajectory, usize),
        heads: &Heads,
        outputs: &[f64],
        totals: &Totals,
        gradient: &mut [f64],
    ) -> LossParts {
        let mut parts = LossParts::default();
        if let Some(force) = trajectory.force[row].filter(|_| !trajectory.gap[row]) {
            let is_loaded = length(&force) > self.contact;
            let gate = sigmoid(outputs[heads.gate]);
            let per = self.force * if is_loaded { self.loaded } else { 1.0 } / (3.0 * totals.forces);
            let mut by_gate = 0.0;
            for axis in 0..3 {
                let raw = outputs[heads.force + axis];
                let (value, slope) = huber(gate * raw - force[axis], self.force_bend);
                parts.force += per * value;
                gradient[heads.force + axis] += per * slope * gate;
                by_gate += per * slope * raw;
            }
            let (value, slope) = cross_entropy(outputs[heads.gate], is_loaded);
            parts.gate += self.gate / totals.forces * value;
            gradient[heads.gate] += by_gate * gate * (1.0 - gate) + self.gate / totals.forces * slope;
        }
        if let Some(is_healthy) = trajectory.is_healthy {
            let (value, slope) = cross_entropy(outputs[heads.condition], is_healthy);
            parts.condition += self.condition / totals.conditions * value;
            gradient[heads.condition] += self.condition / totals.conditions * slope;
        }
        parts
    }
}

/// A force above this is a contact, as published [N]: below the noise of a force sensor.
pub const CONTACT: f64 = 0.01;

fn published_contact() -> f64 {
    CONTACT
}

/// The joint whose motor's condition is learned, as published: the third.
const WATCHED: usize = 2;

/// The motor whose condition is learned: the third, or the last where there are fewer.
pub(super) fn watched_motor(features: &FeatureLayout) -> usize {
    WATCHED.min(features.motors() - 1)
}

/// Outputs of each head: torques, force, gate, conditions.
#[derive(Debug, Clone, Copy)]
pub struct Heads {
    /// Where the force begins.
    pub force: usize,
    /// The contact gate before its sigmoid.
    pub gate: usize,
    /// The watched motor's condition before its sigmoid.
    pub condition: usize,
}

impl Heads {
    /// The torques are the first head.
    pub const TORQUE: usize = 0;

    /// Positions of the outputs for these motors.
    pub fn new(features: &FeatureLayout) -> Self {
        let m = features.motors();
        Self { force: m, gate: m + 3, condition: m + 4 + watched_motor(features) }
    }

    /// Outputs of every head.
    pub fn sizes(features: &FeatureLayout) -> [usize; 4] {
        let m = features.motors();
        [m, 3, 1, m]
    }

    /// Makes another raw force of it, or of the gradient by it.
    pub(super) fn map_force(&self, outputs: &mut [f64], to: impl Fn([f64; 3]) -> [f64; 3]) {
        let own = &mut outputs[self.force..self.force + 3];
        own.copy_from_slice(&to([own[0], own[1], own[2]]));
    }

    /// The estimated force [N]: gate times raw force.
    pub fn force_of(&self, outputs: &[f64]) -> [f64; 3] {
        let gate = sigmoid(outputs[self.gate]);
        std::array::from_fn(|axis| gate * outputs[self.force + axis])
    }
}

/// Divisors of the sums of losses, over all rollouts of an update.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Totals {
    /// States with a measured pose.
    pub poses: f64,
    /// Samples with a label of force.
    pub forces: f64,
    /// Samples with a label of condition.
    pub conditions: f64,
}

impl Totals {
    /// Of rollouts of `horizon` steps; at least one of each, where nothing is divided by it.
    pub fn of(segments: &[Segment<'_>], horizon: usize) -> Self {
        let rows = segments.iter().map(|one| (one.trajectory, one.start..one.start + horizon));
        let poses = segments.iter().flat_map(|one| &one.trajectory.gap[one.start + 1..][..horizon]);
        let poses = poses.filter(|gap| !**gap).count().max(1) as f64;
        Self { poses, ..Self::of_rows(rows) }
    }

    /// Of the labels of recorded rows.
    pub(super) fn of_rows<'a>(rows: impl Iterator<Item = (&'a Trajectory, Range<usize>)>) -> Self {
        let [mut forces, mut conditions] = [0; 2];
        for (trajectory, rows) in rows {
            conditions += usize::from(trajectory.is_healthy.is_some()) * rows.len();
            forces += rows.filter(|row| trajectory.force[*row].is_some() && !trajectory.gap[*row]).count();
        }
        let [forces, conditions] = [forces, conditions].map(|n| n.max(1) as f64);
        Self { poses: 1.0, forces, conditions }
    }
}

/// The weighted losses.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct LossParts {
    /// Of the joints.
    pub position: f64,
    /// Of the aperture.
    pub gripper: f64,
    /// Of the force.
    pub force: f64,
    /// Of the contact gate.
    pub gate: f64,
    /// Of the motor condition.
    pub condition: f64,
}

impl LossParts {
    /// Adds other parts.
    pub fn add(&mut self, other: &Self) {
        self.position += other.position;
        self.gripper += other.gripper;
        self.force += other.force;
        self.gate += other.gate;
        self.condition += other.condition;
    }

    /// All together.
    pub fn sum(&self) -> f64 {
        self.position + self.gripper + self.force + self.gate + self.condition
    }
}

/// The angle between −π and π that differs by whole turns.
pub fn wrap(angle: f64) -> f64 {
    use std::f64::consts::{PI, TAU};
    (angle + PI).rem_euclid(TAU) - PI
}

/// x²/2b up to b, then |x| − b/2, and its derivative: PyTorch's smooth L1.
pub(super) fn huber(x: f64, bend: f64) -> (f64, f64) {
    if x.abs() < bend { (0.5 * x * x / bend, x / bend) } else { (x.abs() - 0.5 * bend, sign(x)) }
}

fn sign(x: f64) -> f64 {
    if x == 0.0 { 0.0 } else { x.signum() }
}

/// 1/(1 + e⁻ˣ).
pub fn sigmoid(x: f64) -> f64 {
    1.0 / (1.0 + (-x).exp())
}

/// −ln of the probability that the logit gives to what is, and its derivative.
fn cross_entropy(logit: f64, is: bool) -> (f64, f64) {
    let signed = if is { -logit } else { logit };
    let value = signed.max(0.0) + (-signed.abs()).exp().ln_1p();
    (value, sigmoid(logit) - f64::from(u8::from(is)))
}

/// Length of a vector.
pub fn length(v: &[f64; 3]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}
