//! How well torques are predicted.

use crate::lagrangian::ArmSamples;

/// Errors of predicted torques.
#[derive(Debug, Clone, PartialEq)]
pub struct TorqueScores {
    /// Mean squared error of every joint [N² m²].
    pub mse: Vec<f64>,
    /// Mean squared error over variance, of every joint [-].
    pub nmse: Vec<f64>,
    /// (11) over all joints about one common mean, as published: offsets between joints count as explained [-].
    pub pooled_r2: f64,
}

impl TorqueScores {
    /// Of `predicted` against `measured`, both [sample][joint].
    pub fn of(n_joints: usize, measured: &[f64], predicted: &[f64]) -> Self {
        let samples = ArmSamples::new(n_joints);
        let errors: Vec<f64> = measured.iter().zip(predicted).map(|(m, p)| p - m).collect();
        let rows = (measured.len() / n_joints) as f64;
        let mse: Vec<f64> = (0..n_joints)
            .map(|j| errors.iter().skip(j).step_by(n_joints).map(|e| e * e).sum::<f64>() / rows)
            .collect();
        let nmse =
            mse.iter().zip(samples.variances(measured)).map(|(mse, variance)| mse / variance).collect();
        let mean = measured.iter().sum::<f64>() / measured.len() as f64;
        let spread: f64 = measured.iter().map(|m| (m - mean).powi(2)).sum();
        let pooled_r2 = 1.0 - errors.iter().map(|e| e * e).sum::<f64>() / spread;
        Self { mse, nmse, pooled_r2 }
    }

    /// Σ of the joints' mean squared errors [N² m²].
    pub fn sum_mse(&self) -> f64 {
        self.mse.iter().sum()
    }

    /// Σ of the joints' normalised errors [-]: the nMSE of the tables.
    pub fn sum_nmse(&self) -> f64 {
        self.nmse.iter().sum()
    }

    /// Mean of 1 − nMSE over the joints [-].
    pub fn mean_r2(&self) -> f64 {
        1.0 - self.sum_nmse() / self.nmse.len() as f64
    }
}
