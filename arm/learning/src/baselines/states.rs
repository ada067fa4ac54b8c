//! States of an arm in units of their spread: what kernels measure distances in.

use crate::lagrangian::ArmSamples;

/// Mean and 1/σ of every number of a state (q, q̇, q̈) in training data.
#[derive(Debug, Clone)]
pub(super) struct StateUnits {
    n_joints: usize,
    units: Vec<[f64; 2]>,
}

impl StateUnits {
    /// Those of `training`.
    pub fn new(training: &ArmSamples) -> Self {
        let n_joints = training.n_joints;
        let rows = training.len() as f64;
        let mut units = Vec::new();
        for values in [&training.q, &training.dq, &training.ddq] {
            for (j, spread) in training.deviations(values).into_iter().enumerate() {
                let mean = values.iter().skip(j).step_by(n_joints).sum::<f64>() / rows;
                units.push([mean, 1.0 / spread.max(1e-9)]);
            }
        }
        Self { n_joints, units }
    }

    /// Numbers of a state.
    pub fn len(&self) -> usize {
        self.units.len()
    }

    /// Writes the state of a sample, each number less its mean and over its spread, to `x` (3 n_joints).
    pub fn write(&self, samples: &ArmSamples, row: usize, x: &mut [f64]) {
        let n = self.n_joints;
        for (k, values) in [&samples.q, &samples.dq, &samples.ddq].into_iter().enumerate() {
            for j in 0..n {
                let [mean, per] = self.units[k * n + j];
                x[k * n + j] = (values[row * n + j] - mean) * per;
            }
        }
    }
}
