//! Inputs of the network from a sample, and how a simulated state changes them.

use hysteron_base::BadInput;
use serde::{Deserialize, Serialize};

/// The gripper's motor as the last one, and how its angle opens the jaws: aperture = slope · angle + offset.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GripperAxis {
    /// [m/rad].
    pub slope: f64,
    /// [m].
    pub offset: f64,
}

/// Positions of the inputs, in the order of NeuralActuator's release: goals, positions, aperture, currents, speeds, voltages,
/// temperatures, the aperture's goal, errors of the joints, error of the aperture. 36 for four joints and a gripper.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FeatureLayout {
    /// Joints of the arm n.
    pub joints: usize,
    /// The gripper, where there is one.
    pub gripper: Option<GripperAxis>,
}

/// Inputs beyond so many spreads are taken as that many.
const CLIP: f64 = 10.0;

impl FeatureLayout {
    /// Motors m: one for each joint, and that of the gripper.
    pub fn motors(&self) -> usize {
        self.joints + usize::from(self.gripper.is_some())
    }

    /// Numbers of a sample.
    pub fn len(&self) -> usize {
        self.errors() + self.motors()
    }

    /// False: every arm has joints.
    pub fn is_empty(&self) -> bool {
        self.joints == 0
    }

    /// Numbers of a state: positions of all motors, then their speeds.
    pub fn state(&self) -> usize {
        2 * self.motors()
    }

    /// Where the goals begin.
    pub const GOALS: usize = 0;

    /// Where the positions begin.
    pub(super) fn positions(&self) -> usize {
        self.motors()
    }

    /// Where the currents begin.
    pub fn currents(&self) -> usize {
        2 * self.motors()
    }

    fn speeds(&self) -> usize {
        3 * self.motors()
    }

    /// Where the temperatures begin.
    pub(super) fn temperatures(&self) -> usize {
        5 * self.motors()
    }

    fn aperture_goal(&self) -> usize {
        6 * self.motors()
    }

    fn errors(&self) -> usize {
        6 * self.motors() + usize::from(self.gripper.is_some())
    }

    /// A sample's inputs from goals, state, currents, voltages and temperatures of all motors and, with a gripper, aperture and
    /// its goal; angles and lengths in SI.
    pub fn gather(
        &self,
        [goals, state, currents, voltages, temperatures]: [&[f64]; 5],
        aperture_goal: f64,
        to: &mut [f64],
    ) {
        let m = self.motors();
        to[..m].copy_from_slice(goals);
        to[self.currents()..][..m].copy_from_slice(currents);
        to[4 * m..][..m].copy_from_slice(voltages);
        to[self.temperatures()..][..m].copy_from_slice(temperatures);
        if self.gripper.is_some() {
            to[self.aperture_goal()] = aperture_goal;
        }
        self.set_state(state, to);
    }

    /// Replaces the inputs that depend on the state: positions, speeds and errors.
    pub fn set_state(&self, state: &[f64], to: &mut [f64]) {
        let (m, n) = (self.motors(), self.joints);
        to[self.positions()..][..n].copy_from_slice(&state[..n]);
        to[self.speeds()..][..m].copy_from_slice(&state[m..2 * m]);
        for k in 0..n {
            to[self.errors() + k] = to[k] - state[k];
        }
        if let Some(gripper) = &self.gripper {
            let aperture = gripper.slope * state[n] + gripper.offset;
            to[self.positions() + n] = aperture;
            to[self.errors() + n] = to[self.aperture_goal()] - aperture;
        }
    }

    /// Adds the gradient by the state from that by the inputs.
    pub fn state_gradient(&self, by_inputs: &[f64], by_state: &mut [f64]) {
        let (m, n) = (self.motors(), self.joints);
        for k in 0..n {
            by_state[k] += by_inputs[self.positions() + k] - by_inputs[self.errors() + k];
        }
        for k in 0..m {
            by_state[m + k] += by_inputs[self.speeds() + k];
        }
        if let Some(gripper) = &self.gripper {
            by_state[n] += gripper.slope * (by_inputs[self.positions() + n] - by_inputs[self.errors() + n]);
        }
    }

    /// Spreads below these are not plausible: 0.05 rad, 10 mA, 0.1 rad/s, 0.1 V, 1 K, 1 mm.
    pub(super) fn floors(&self) -> Vec<f64> {
        let (m, n) = (self.motors(), self.joints);
        let jaws = usize::from(self.gripper.is_some());
        let parts = [
            (m, 0.05),
            (n, 0.05),
            (jaws, 1e-3),
            (m, 0.01),
            (m, 0.1),
            (m, 0.1),
            (m, 1.0),
            (jaws, 1e-3),
            (n, 0.05),
            (jaws, 1e-3),
        ];
        parts.into_iter().flat_map(|(n, floor)| std::iter::repeat_n(floor, n)).collect()
    }
}

/// Inputs as the network gets them: over the spread of the training data, limited to ±10.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct InputScale {
    mean: Vec<f64>,
    spread: Vec<f64>,
}

impl InputScale {
    /// From rows of inputs.
    ///
    /// # Errors
    /// `BadInput` where there is no row.
    pub fn of<'a>(
        features: &FeatureLayout,
        rows: impl Iterator<Item = &'a [f64]> + Clone,
    ) -> Result<Self, BadInput> {
        Self::with_floors(&features.floors(), rows)
    }

    /// From rows of inputs whose spreads are no less than `floors`.
    pub(super) fn with_floors<'a>(
        floors: &[f64],
        rows: impl Iterator<Item = &'a [f64]> + Clone,
    ) -> Result<Self, BadInput> {
        let n = rows.clone().count();
        if n == 0 {
            return Err(BadInput::new("recordings", "at least one sample", "none"));
        }
        let mut mean = vec![0.0; floors.len()];
        for row in rows.clone() {
            mean.iter_mut().zip(row).for_each(|(mean, x)| *mean += x / n as f64);
        }
        let mut square = vec![0.0; floors.len()];
        for row in rows {
            for (k, x) in row.iter().enumerate() {
                square[k] += (x - mean[k]).powi(2) / n as f64;
            }
        }
        let spread = square.iter().zip(floors).map(|(square, floor)| square.sqrt().max(*floor)).collect();
        Ok(Self { mean, spread })
    }

    /// Whether it is for so many inputs, with finite means and spreads above zero.
    pub fn is_for(&self, n: usize) -> bool {
        self.mean.len() == n
            && self.spread.len() == n
            && self.mean.iter().all(|mean| mean.is_finite())
            && self.spread.iter().all(|spread| *spread > 0.0 && spread.is_finite())
    }

    /// Scaled and clipped value of input `k`, and its derivative.
    pub fn at(&self, k: usize, x: f64) -> (f64, f64) {
        let scaled = (x - self.mean[k]) / self.spread[k];
        if scaled.abs() > CLIP { (CLIP.copysign(scaled), 0.0) } else { (scaled, 1.0 / self.spread[k]) }
    }
}
