//! Ridge regression on random Fourier features: a Gaussian kernel in finitely many terms.

use hysteron_base::{parallel, rng};
use hysteron_learn::ridge::{NormalEquations, predict};
use rand::RngExt;
use rayon::prelude::*;

use super::states::StateUnits;
use crate::lagrangian::ArmSamples;

/// Samples whose features are in memory at a time.
const ROWS: usize = 256;

/// √2 cos(ω · x + b) of states x = (q, q̇, q̈) in units of their spread, ω normal with deviation 1/length, b uniform.
///
/// # Reference
/// Rahimi, Recht (2007), Random features for large-scale kernel machines, algorithm 1.
#[derive(Debug, Clone)]
pub struct FourierFeatures {
    n_joints: usize,
    units: StateUnits,
    /// [feature][number of the state], over the length.
    frequencies: Vec<f64>,
    phases: Vec<f64>,
}

impl FourierFeatures {
    /// `n_features` features of this length, in spreads of `training`.
    pub fn new(training: &ArmSamples, n_features: usize, length: f64, seed: u64) -> Self {
        let n = training.n_joints;
        let mut rng = rng(seed, "arm/fourier");
        // Normal numbers by Box and Muller.
        let mut normal = || {
            let (u, v): (f64, f64) = (rng.random(), rng.random());
            (-2.0 * (1.0 - u).ln()).sqrt() * (std::f64::consts::TAU * v).cos()
        };
        let frequencies = (0..n_features * 3 * n).map(|_| normal() / length).collect();
        let phases = (0..n_features).map(|_| rng.random_range(0.0..std::f64::consts::TAU)).collect();
        Self { n_joints: n, units: StateUnits::new(training), frequencies, phases }
    }

    /// How many features there are, a constant included.
    pub fn width(&self) -> usize {
        self.phases.len() + 1
    }

    fn rows(&self, samples: &ArmSamples, rows: &[usize], out: &mut Vec<f64>) {
        let n = self.n_joints;
        out.clear();
        let mut x = vec![0.0; 3 * n];
        for row in rows {
            self.units.write(samples, *row, &mut x);
            for (w, b) in self.frequencies.chunks_exact(3 * n).zip(&self.phases) {
                let phase: f64 = w.iter().zip(&x).map(|(w, x)| w * x).sum();
                out.push(std::f64::consts::SQRT_2 * (phase + b).cos());
            }
            out.push(1.0);
        }
    }

    /// Sums of one trajectory each, towards `targets` [sample][joint]; every `stride`-th sample is taken.
    pub fn normal_equations(
        &self,
        samples: &ArmSamples,
        targets: &[f64],
        stride: usize,
    ) -> Vec<NormalEquations> {
        let n = self.n_joints;
        let of = |trajectory: &std::ops::Range<usize>| {
            let mut sums = NormalEquations::new(self.width(), n);
            let taken: Vec<usize> = trajectory.clone().step_by(stride).collect();
            let mut features = Vec::new();
            for rows in taken.chunks(ROWS) {
                self.rows(samples, rows, &mut features);
                let outputs: Vec<f64> =
                    rows.iter().flat_map(|i| targets[n * i..n * (i + 1)].to_vec()).collect();
                sums.add(&features, &outputs);
            }
            sums
        };
        parallel::map(&samples.trajectories, of)
    }

    /// Outputs [sample][joint] with these weights.
    pub fn predict(&self, weights: &[f64], samples: &ArmSamples) -> Vec<f64> {
        let n = self.n_joints;
        let mut found = vec![0.0; samples.len() * n];
        found.par_chunks_mut(ROWS * n).enumerate().for_each(|(b, out)| {
            let rows: Vec<usize> = (b * ROWS..b * ROWS + out.len() / n).collect();
            let mut features = Vec::new();
            self.rows(samples, &rows, &mut features);
            predict(&features, weights, self.width(), out);
        });
        found
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)] // a test may stop where it stands
mod tests {
    use super::*;

    #[test]
    fn products_of_features_approach_the_gaussian_kernel() {
        let mut samples = ArmSamples::new(1);
        let q: Vec<f64> = (0..40).map(|i| (0.7 * f64::from(i)).sin()).collect();
        let dq: Vec<f64> = (0..40).map(|i| (1.9 * f64::from(i)).cos()).collect();
        samples.push([&q, &dq, &dq, &q], [&[], &[]]).unwrap();
        let n = 20_000;
        let features = FourierFeatures::new(&samples, n, 2.0, 1);
        let mut rows = Vec::new();
        features.rows(&samples, &[3, 8], &mut rows);
        let (a, b) = rows.split_at(features.width());
        let product = (a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>() - 1.0) / n as f64;
        let [sq, sdq] = [samples.deviations(&q)[0], samples.deviations(&dq)[0]];
        let distance = ((q[3] - q[8]) / sq).powi(2) + 2.0 * ((dq[3] - dq[8]) / sdq).powi(2);
        let kernel = (-0.5 * distance / 4.0).exp();
        // A mean of n numbers of spread about 1.
        assert!((product - kernel).abs() < 4.0 / (n as f64).sqrt(), "{product} {kernel}");
    }
}
