//! How well an actuator does: rollouts by horizon, forces, contact, condition.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::actuator::NeuralActuator;
use super::closed_loop::ActuatorLoop;
use super::data::Trajectory;
use super::features::FeatureLayout;
use super::loss::{Heads, length, sigmoid, wrap};
use super::segment::{Segment, TelemetrySource};
use super::simulation::ArmSimulation;

/// A whole trajectory in simulation, from its recorded initial state.
#[derive(Debug, Clone, PartialEq)]
pub struct ArmRollout {
    /// Positions of all motors at every row (rows × m) [rad].
    pub positions: Vec<f64>,
    /// Force on the tip at every row but the last [N].
    pub force: Vec<[f64; 3]>,
    /// Probability of contact there.
    pub gate: Vec<f64>,
    /// Probability that the watched motor is healthy there.
    pub condition: Vec<f64>,
}

/// Rolls a trajectory out.
pub fn roll_out(
    actuator: &NeuralActuator,
    simulation: &ArmSimulation,
    trajectory: &Trajectory,
    telemetry: TelemetrySource<'_>,
) -> ArmRollout {
    let horizon = trajectory.len() - 1;
    let segment = Segment { trajectory, start: 0, telemetry };
    let mut closed =
        ActuatorLoop::new((simulation, &actuator.scale), (&actuator.network, None), vec![segment], horizon);
    closed.run(&closed.recorded_start());
    let m = actuator.features.motors();
    let positions = closed.states().chunks_exact(2 * m).flat_map(|state| &state[..m]).copied().collect();
    let heads = Heads::new(&actuator.features);
    let n = actuator.network.shape().outputs();
    let mut rollout = ArmRollout { positions, force: Vec::new(), gate: Vec::new(), condition: Vec::new() };
    for outputs in closed.outputs().chunks_exact(n) {
        let outputs: Vec<f64> = outputs.iter().map(|y| f64::from(*y)).collect();
        rollout.force.push(heads.force_of(&outputs));
        rollout.gate.push(sigmoid(outputs[heads.gate]));
        rollout.condition.push(sigmoid(outputs[heads.condition]));
    }
    rollout
}

/// Mean absolute errors of poses over the first steps of rollouts.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PoseScores {
    /// Of each joint [deg].
    pub joints_deg: Vec<f64>,
    /// Of the aperture [mm].
    pub gripper_mm: Option<f64>,
    /// Trajectories.
    pub trajectories: usize,
}

impl PoseScores {
    /// Mean over the joints [deg].
    pub fn mean_deg(&self) -> f64 {
        self.joints_deg.iter().sum::<f64>() / self.joints_deg.len() as f64
    }
}

/// Errors of positions (rows × m, for each trajectory) over the first `horizon` steps after the initial state, as
/// MAE_j(T) of the paper: a mean over steps, then over trajectories. Rows that were filled in do not count.
pub fn pose_scores(
    features: &FeatureLayout,
    trajectories: &[Trajectory],
    positions: &[Vec<f64>],
    horizon: usize,
) -> PoseScores {
    let (m, n) = (features.motors(), features.joints);
    let mut sums = vec![0.0; m];
    for (trajectory, positions) in trajectories.iter().zip(positions) {
        let rows: Vec<usize> =
            (1..trajectory.len().min(horizon + 1)).filter(|row| !trajectory.gap[*row]).collect();
        for (k, sum) in sums.iter_mut().enumerate() {
            let off = |row: &usize| wrap(positions[row * m + k] - trajectory.state_at(*row)[k]).abs();
            *sum += rows.iter().map(off).sum::<f64>() / rows.len().max(1) as f64;
        }
    }
    let per = 1.0 / trajectories.len().max(1) as f64;
    let gripper_mm = features.gripper.map(|gripper| 1e3 * gripper.slope.abs() * sums[n] * per);
    let joints_deg = sums[..n].iter().map(|sum| (sum * per).to_degrees()).collect();
    PoseScores { joints_deg, gripper_mm, trajectories: trajectories.len() }
}

/// Errors of forces over the samples that have a label.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ForceScores {
    /// Mean absolute error of the three axes, over all labelled samples, as published [N].
    pub mean_of_axes_n: f64,
    /// The same over the samples under force.
    pub loaded_mean_of_axes_n: f64,
    /// Mean absolute error of the axis along which most of the force is, over the samples under force [N].
    pub loaded_axis_n: f64,
    /// Mean length of the error there [N].
    pub loaded_norm_n: f64,
    /// Share of the samples without force at which contact is reported [-].
    pub false_contact: f64,
    /// Share of the samples under force at which none is [-].
    pub missed_contact: f64,
    /// Samples with a label, and those under force.
    pub samples: [usize; 2],
}

/// Scores of forces and gates (rows − 1, for each trajectory) over the first `horizon` steps, where a force longer than `contact` [N]
/// is a contact; `None` without any label.
pub fn force_scores(
    trajectories: &[Trajectory],
    forces: &[(Vec<[f64; 3]>, Vec<f64>)],
    (horizon, contact): (usize, f64),
) -> Option<ForceScores> {
    let (mut all, mut loaded, mut axis, mut norm, mut wrong) = (0.0, 0.0, 0.0, 0.0, [0.0; 2]);
    let mut samples = [0; 2];
    for (trajectory, (forces, gates)) in trajectories.iter().zip(forces) {
        for (row, (force, gate)) in forces.iter().zip(gates).enumerate().take(horizon) {
            let Some(label) = trajectory.force[row].filter(|_| !trajectory.gap[row]) else { continue };
            let off: [f64; 3] = std::array::from_fn(|k| force[k] - label[k]);
            let mean = off.iter().map(|x| x.abs()).sum::<f64>() / 3.0;
            samples[0] += 1;
            all += mean;
            if length(&label) > contact {
                samples[1] += 1;
                loaded += mean;
                let along = (0..3).max_by(|a, b| label[*a].abs().total_cmp(&label[*b].abs())).unwrap_or(2);
                axis += off[along].abs();
                norm += length(&off);
                wrong[1] += f64::from(u8::from(*gate < 0.5));
            } else {
                wrong[0] += f64::from(u8::from(*gate >= 0.5));
            }
        }
    }
    if samples[0] == 0 {
        return None;
    }
    let [n, under] = samples.map(|n| n as f64);
    Some(ForceScores {
        mean_of_axes_n: all / n,
        loaded_mean_of_axes_n: loaded / under,
        loaded_axis_n: axis / under,
        loaded_norm_n: norm / under,
        false_contact: wrong[0] / (n - under),
        missed_contact: wrong[1] / under,
        samples,
    })
}

/// Accuracy at one half and area under the curve of condition, sample by sample; `None` unless both conditions are there.
pub fn condition_scores(trajectories: &[Trajectory], conditions: &[Vec<f64>]) -> Option<[f64; 2]> {
    let mut all: Vec<(f64, bool)> = Vec::new();
    for (trajectory, values) in trajectories.iter().zip(conditions) {
        if let Some(is_healthy) = trajectory.is_healthy {
            all.extend(values.iter().map(|value| (*value, is_healthy)));
        }
    }
    let right =
        all.iter().filter(|(value, is)| (*value >= 0.5) == *is).count() as f64 / all.len().max(1) as f64;
    Some([right, area_under_curve(&all)?])
}

/// Probability that a value of what is exceeds a value of what is not, ties counted half (Mann, Whitney 1947); `None` where one of both
/// is missing.
pub fn area_under_curve(values: &[(f64, bool)]) -> Option<f64> {
    let mut sorted: Vec<&(f64, bool)> = values.iter().collect();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (mut ranks, mut start) = (0.0, 0);
    while start < sorted.len() {
        let same = sorted[start..].iter().take_while(|value| value.0 == sorted[start].0).count();
        let rank = start as f64 + 0.5 * (same as f64 + 1.0);
        ranks += rank * sorted[start..start + same].iter().filter(|value| value.1).count() as f64;
        start += same;
    }
    let positive = values.iter().filter(|value| value.1).count() as f64;
    let negative = values.len() as f64 - positive;
    (positive > 0.0 && negative > 0.0)
        .then(|| (ranks - 0.5 * positive * (positive + 1.0)) / (positive * negative))
}
