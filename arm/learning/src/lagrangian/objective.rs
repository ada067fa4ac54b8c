//! The loss of a model on samples and its gradient, on all threads.

use hysteron_learn::{ByParameters, Float, LeastSquares, Objective};
use rayon::prelude::*;

use super::block::BlockMotion;
use super::network::{Evaluator, NetworkShape, Targets};
use super::{ArmSamples, Variant};

/// Samples that go through a network at once.
const ROWS: usize = 128;
/// Parts of a batch that may run at the same time. Fixed, so that sums do not depend on the number of threads.
const LANES: usize = 8;
/// Parameters whose gradients a thread sums at once.
const SUMMED: usize = 4096;

/// The weighted mean squared error of a model on training samples, and its error on validation samples.
pub struct TorqueObjective<'a, T> {
    shape: &'a NetworkShape,
    training: &'a ArmSamples,
    validation: &'a ArmSamples,
    /// Position features of training and validation samples, computed once.
    numbers: [Vec<[f64; 2]>; 2],
    /// Of every squared error of an output, over the number of outputs.
    weights: Vec<f64>,
    penalty: f64,
    /// Weights of validation: 1/variance of the training's torques.
    per_variance: Vec<f64>,
    /// One for every thread that takes lanes: what a pass remembers of the lane before is still near the processor.
    evaluators: Vec<Evaluator<T>>,
    /// Of every lane.
    gradients: Vec<Vec<T>>,
}

/// How the errors of joints are weighed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum JointWeights {
    /// All the same: (5).
    Equal,
    /// By the inverse variance of every joint's torque: (10).
    InverseVariance,
}

/// q, q̇, q̈ of a model of velocities, q, p, ṗ of one of momenta.
pub(crate) fn motion(samples: &ArmSamples, variant: Variant) -> [&[f64]; 3] {
    if variant.is_hamiltonian() {
        [&samples.q, &samples.momenta[0], &samples.momenta[1]]
    } else {
        [&samples.q, &samples.dq, &samples.ddq]
    }
}

/// The same with what networks see of the positions.
fn known_motion<'a>(samples: &'a ArmSamples, variant: Variant, numbers: &'a [[f64; 2]]) -> BlockMotion<'a> {
    BlockMotion { series: motion(samples, variant), numbers: Some(numbers) }
}

impl<'a, T: Float> TorqueObjective<'a, T> {
    /// `penalty` is λ of (10).
    pub fn new(
        shape: &'a NetworkShape,
        [training, validation]: [&'a ArmSamples; 2],
        weights: JointWeights,
        penalty: f64,
    ) -> Self {
        let inverse = |values: &[f64]| training.variances(values).into_iter().map(|v| 1.0 / v.max(1e-20));
        let mut per_variance: Vec<f64> = inverse(&training.tau).collect();
        if shape.variant.is_hamiltonian() {
            per_variance.extend(inverse(&training.dq));
        }
        let n = per_variance.len() as f64;
        let of = |v: &f64| match weights {
            JointWeights::Equal => 1.0,
            JointWeights::InverseVariance => v / n,
        };
        let n_evaluators = rayon::current_num_threads().min(LANES);
        let evaluators = (0..n_evaluators).map(|_| Evaluator::new(shape)).collect();
        let gradients = vec![vec![T::default(); shape.n_parameters()]; LANES];
        let weights = per_variance.iter().map(of).collect();
        let features = shape.features();
        let numbers = [training, validation].map(|samples| features.all_numbers(&samples.q));
        Self { shape, training, validation, numbers, weights, penalty, per_variance, evaluators, gradients }
    }

    fn lanes_of_a_thread(&self) -> usize {
        LANES.div_ceil(self.evaluators.len())
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

/// The sum of the gradients of all lanes, in their order.
fn sum_up<T: Float>(of_lanes: &[Vec<T>], sum: &mut [T]) {
    let Some((first, rest)) = of_lanes.split_first() else { return };
    let chunks = sum.par_chunks_mut(SUMMED).zip(first.par_chunks(SUMMED)).enumerate();
    chunks.for_each(|(k, (sum, first))| {
        sum.copy_from_slice(first);
        for part in rest {
            sum.iter_mut().zip(&part[k * SUMMED..]).for_each(|(sum, g)| *sum += *g);
        }
    });
}

impl<T: Float> Objective<T> for TorqueObjective<'_, T> {
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
        let shares = Self::shares(samples);
        let lanes = self.lanes_of_a_thread();
        let (evaluators, gradients) = (&mut self.evaluators, &mut self.gradients);
        let lane = |evaluator: &mut Evaluator<T>, gradient: &mut [T], blocks: &[&[usize]]| {
            if blocks.is_empty() {
                gradient.fill(T::default());
            }
            let mut loss = 0.0;
            for (block, rows) in blocks.iter().enumerate() {
                evaluator.evaluate(parameters, motion, rows.iter().copied());
                let into =
                    if block == 0 { ByParameters::First(gradient) } else { ByParameters::Sum(gradient) };
                loss += evaluator.add_loss(parameters, &targets, rows, per_row, into);
            }
            loss
        };
        let losses: Vec<f64> = evaluators
            .par_iter_mut()
            .zip(gradients.par_chunks_mut(lanes).zip(shares.par_chunks(lanes)))
            .flat_map_iter(|(evaluator, (gradients, shares))| {
                gradients.iter_mut().zip(shares).map(|(own, blocks)| lane(evaluator, own, blocks))
            })
            .collect();
        sum_up(gradients, gradient);
        losses.iter().sum()
    }

    fn validate(&mut self, parameters: &[T]) -> f64 {
        let rows: Vec<usize> = (0..self.validation.len()).collect();
        let motion = known_motion(self.validation, self.shape.variant, &self.numbers[1]);
        let targets = Targets {
            values: [&self.validation.tau, &self.validation.dq],
            weights: &self.per_variance,
            penalty: 0.0,
        };
        let shares = Self::shares(&rows);
        let lanes = self.lanes_of_a_thread();
        let sums: Vec<f64> = self
            .evaluators
            .par_iter_mut()
            .zip(shares.par_chunks(lanes))
            .flat_map_iter(|(evaluator, shares)| {
                let mut of_block = |rows: &&[usize]| {
                    evaluator.evaluate(parameters, motion, rows.iter().copied());
                    evaluator.squared_error(&targets, rows)
                };
                shares.iter().map(move |blocks| blocks.iter().map(&mut of_block).sum::<f64>())
            })
            .collect();
        (sums.iter().sum::<f64>() / (rows.len() * self.per_variance.len()) as f64).sqrt()
    }
}

impl LeastSquares for TorqueObjective<'_, f64> {
    fn n_residuals(&self) -> usize {
        self.evaluators[0].n_residuals(self.penalty)
    }

    fn jacobian(&mut self, parameters: &[f64], samples: &[usize], jacobian: &mut [f64]) {
        let rows = samples.len().div_ceil(LANES).max(1);
        let width = self.n_residuals() * parameters.len();
        let motion = known_motion(self.training, self.shape.variant, &self.numbers[0]);
        let (weights, penalty) = (&self.weights, self.penalty);
        let of_a_thread = rows * self.lanes_of_a_thread();
        self.evaluators
            .par_iter_mut()
            .zip(samples.par_chunks(of_a_thread))
            .zip(jacobian.par_chunks_mut(of_a_thread * width))
            .for_each(|((evaluator, samples), jacobian)| {
                for (rows, jacobian) in samples.chunks(rows).zip(jacobian.chunks_mut(rows * width)) {
                    evaluator.evaluate(parameters, motion, rows.iter().copied());
                    evaluator.jacobian(parameters, weights, penalty, jacobian);
                }
            });
    }
}
