//! The loss of a model on samples and its gradient, on all threads.

use hysteron_learn::{LeastSquares, Objective, Real};
use rayon::prelude::*;

use super::block::Motion;
use super::network::{Evaluator, NetworkShape, Targets};
use super::{Samples, Variant};

/// Samples that go through a network at once.
const ROWS: usize = 128;
/// Parts of a batch that may run at the same time. Fixed, so that sums do not depend on the number of threads.
const LANES: usize = 8;

/// The weighted mean squared error of a model on training samples, and its error on validation samples.
pub struct TorqueObjective<'a, T> {
    shape: &'a NetworkShape,
    training: &'a Samples,
    validation: &'a Samples,
    /// What networks see of the positions of both, taken once.
    numbers: [Vec<[f64; 2]>; 2],
    /// Of every squared error of an output, over the number of outputs.
    weights: Vec<f64>,
    penalty: f64,
    /// Weights of validation: 1/variance of the training's torques.
    per_variance: Vec<f64>,
    lanes: Vec<(Evaluator<T>, Vec<T>)>,
}

/// How the errors of joints are weighed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Weights {
    /// All the same: (5).
    Equal,
    /// By the inverse variance of every joint's torque: (10).
    InverseVariance,
}

/// q, q̇, q̈ of a model of velocities, q, p, ṗ of one of momenta.
pub(crate) fn motion(samples: &Samples, variant: Variant) -> [&[f64]; 3] {
    if variant.is_hamiltonian() {
        [&samples.q, &samples.momenta[0], &samples.momenta[1]]
    } else {
        [&samples.q, &samples.dq, &samples.ddq]
    }
}

/// The same with what networks see of the positions.
fn known_motion<'a>(samples: &'a Samples, variant: Variant, numbers: &'a [[f64; 2]]) -> Motion<'a> {
    Motion { series: motion(samples, variant), numbers: Some(numbers) }
}

impl<'a, T: Real> TorqueObjective<'a, T> {
    /// `penalty` is λ of (10).
    pub fn new(
        shape: &'a NetworkShape,
        [training, validation]: [&'a Samples; 2],
        weights: Weights,
        penalty: f64,
    ) -> Self {
        let inverse = |values: &[f64]| training.variances(values).into_iter().map(|v| 1.0 / v.max(1e-20));
        let mut per_variance: Vec<f64> = inverse(&training.tau).collect();
        if shape.variant.is_hamiltonian() {
            per_variance.extend(inverse(&training.dq));
        }
        let n = per_variance.len() as f64;
        let of = |v: &f64| match weights {
            Weights::Equal => 1.0,
            Weights::InverseVariance => v / n,
        };
        let lanes =
            (0..LANES).map(|_| (Evaluator::new(shape), vec![T::default(); shape.n_parameters()])).collect();
        let weights = per_variance.iter().map(of).collect();
        let features = shape.features();
        let numbers = [training, validation].map(|samples| features.all_numbers(&samples.q));
        Self { shape, training, validation, numbers, weights, penalty, per_variance, lanes }
    }

    /// Rows of a batch that a lane takes.
    fn shares(samples: &[usize]) -> Vec<Vec<&[usize]>> {
        let rows = samples.len().div_ceil(LANES).clamp(1, ROWS);
        let mut shares = vec![Vec::new(); LANES];
        for (b, block) in samples.chunks(rows).enumerate() {
            shares[b % LANES].push(block);
        }
        shares
    }
}

impl<T: Real> Objective<T> for TorqueObjective<'_, T> {
    fn n_samples(&self) -> usize {
        self.training.len()
    }

    fn gradient(&mut self, parameters: &[T], samples: &[usize], gradient: &mut [T]) -> f64 {
        let per_row = 1.0 / samples.len() as f64;
        let motion = known_motion(self.training, self.shape.variant, &self.numbers[0]);
        let targets = Targets {
            values: [&self.training.tau, &self.training.dq],
            weights: &self.weights,
            penalty: self.penalty,
        };
        let losses: Vec<f64> = self
            .lanes
            .par_iter_mut()
            .zip(Self::shares(samples))
            .map(|((evaluator, gradient), blocks)| {
                gradient.fill(T::default());
                let mut loss = 0.0;
                for rows in blocks {
                    evaluator.evaluate(parameters, motion, rows.iter().copied());
                    loss += evaluator.add_loss(parameters, &targets, rows, per_row, gradient);
                }
                loss
            })
            .collect();
        gradient.fill(T::default());
        for (_, part) in &self.lanes {
            for (sum, g) in gradient.iter_mut().zip(part) {
                *sum += *g;
            }
        }
        losses.iter().sum()
    }

    fn validate(&mut self, parameters: &[T]) -> f64 {
        let n = self.shape.n_joints();
        let rows: Vec<usize> = (0..self.validation.len()).collect();
        let motion = known_motion(self.validation, self.shape.variant, &self.numbers[1]);
        let targets = [&self.validation.tau, &self.validation.dq];
        let weights = &self.per_variance;
        let sums: Vec<f64> = self
            .lanes
            .par_iter_mut()
            .zip(Self::shares(&rows))
            .map(|((evaluator, _), blocks)| {
                let mut sum = 0.0;
                for rows in blocks {
                    evaluator.evaluate(parameters, motion, rows.iter().copied());
                    let outputs = evaluator.outputs.chunks_exact(weights.len());
                    for (outputs, row) in outputs.zip(rows) {
                        for (j, y) in outputs.iter().enumerate() {
                            let error = y.to_f64() - targets[j / n][row * n + j % n];
                            sum += weights[j] * error * error;
                        }
                    }
                }
                sum
            })
            .collect();
        (sums.iter().sum::<f64>() / (rows.len() * weights.len()) as f64).sqrt()
    }
}

impl LeastSquares for TorqueObjective<'_, f64> {
    fn n_residuals(&self) -> usize {
        self.lanes[0].0.n_residuals(self.penalty)
    }

    fn jacobian(&mut self, parameters: &[f64], samples: &[usize], jacobian: &mut [f64]) {
        let rows = samples.len().div_ceil(LANES).max(1);
        let width = self.n_residuals() * parameters.len();
        let motion = known_motion(self.training, self.shape.variant, &self.numbers[0]);
        let (weights, penalty) = (&self.weights, self.penalty);
        self.lanes
            .par_iter_mut()
            .zip(samples.par_chunks(rows))
            .zip(jacobian.par_chunks_mut(rows * width))
            .for_each(|(((evaluator, _), rows), jacobian)| {
                evaluator.evaluate(parameters, motion, rows.iter().copied());
                evaluator.jacobian(parameters, weights, penalty, jacobian);
            });
    }
}
