//! A model of the drives' currents, which makes a simulation pure.

use hysteron_base::BadInput;
use hysteron_learn::ridge::NormalEquations;
use serde::{Deserialize, Serialize};

use super::data::{Trajectory, usual_gain};
use super::features::FeatureLayout;

/// Regularisation of columns that the data does not distinguish; relative.
pub(super) const PENALTY: f64 = 1e-9;

/// Current of each motor as a line over its error, times the gain of its position loop, and speed: a position servo without what it
/// remembers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CurrentModel {
    /// For each motor, current per error [A/rad], per speed [A s/rad], and at zero [A].
    pub coefficients: Vec<[f64; 3]>,
    /// Gain of the position loops for which the current per error holds, as the register has it; none where recordings have none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub position_gain: Option<f64>,
}

/// Error and speed of every motor, from inputs in SI.
fn error_and_speed(features: &FeatureLayout, inputs: &[f64], motor: usize) -> [f64; 2] {
    let m = features.motors();
    let position = match features.gripper {
        Some(gripper) if motor == features.joints => (inputs[m + motor] - gripper.offset) / gripper.slope,
        _ => inputs[m + motor],
    };
    [inputs[motor] - position, inputs[3 * m + motor]]
}

impl CurrentModel {
    /// By least squares over all rows.
    ///
    /// # Errors
    /// `BadInput` where there is no row, or some recordings have their gain and others do not.
    pub fn fit(features: &FeatureLayout, trajectories: &[Trajectory]) -> Result<Self, BadInput> {
        if trajectories.is_empty() {
            return Err(BadInput::new("recordings", "one or more", "none"));
        }
        let position_gain = usual_gain(trajectories)?;
        let one = |motor: usize| {
            let mut normal = NormalEquations::new(3, 1);
            for trajectory in trajectories {
                let rows = || trajectory.inputs.chunks_exact(features.len());
                let gain = trajectory.gain_over(position_gain);
                let of_row = |row| {
                    let [error, speed] = error_and_speed(features, row, motor);
                    [gain * error, speed, 1.0]
                };
                let currents: Vec<f64> = rows().map(|row| row[features.currents() + motor]).collect();
                normal.add(&rows().flat_map(of_row).collect::<Vec<f64>>(), &currents);
            }
            let found = normal.solve(PENALTY);
            [found[0], found[1], found[2]]
        };
        Ok(Self { coefficients: (0..features.motors()).map(one).collect(), position_gain })
    }

    /// Puts the model's currents in place of the recorded ones, and voltages and temperatures of `first`; `gain` is over the model's.
    pub fn replace(&self, features: &FeatureLayout, (first, gain): (&[f64], f64), inputs: &mut [f64]) {
        let m = features.motors();
        inputs[4 * m..6 * m].copy_from_slice(&first[4 * m..6 * m]);
        for (k, [by_error, by_speed, zero]) in self.coefficients.iter().enumerate() {
            let [error, speed] = error_and_speed(features, inputs, k);
            inputs[features.currents() + k] = gain * by_error * error + by_speed * speed + zero;
        }
    }

    /// Moves the gradient by the currents to positions and speeds; `gain` is over the model's.
    pub fn pull_back(&self, features: &FeatureLayout, gain: f64, by_inputs: &mut [f64]) {
        let m = features.motors();
        for (k, [by_error, by_speed, _]) in self.coefficients.iter().enumerate() {
            let by_current = std::mem::take(&mut by_inputs[features.currents() + k]);
            let per = match features.gripper {
                Some(gripper) if k == features.joints => 1.0 / gripper.slope,
                _ => 1.0,
            };
            by_inputs[m + k] -= gain * by_error * by_current * per;
            by_inputs[3 * m + k] += by_speed * by_current;
        }
    }
}
