//! Gaussian-process regression of torques: the kernel itself, on as many samples as a factorisation bears.

use hysteron_base::BadInput;
use hysteron_fit::folds;
use hysteron_learn::ridge::{predict, solve_positive_definite};
use rayon::prelude::*;

use super::selection::{Choice, FOLDS, GoesOn};
use super::states::StateUnits;
use crate::lagrangian::{ArmSamples, TorqueScores};

/// Samples that the factorisation bears: n³/3 operations and 8 n² bytes.
pub const MAX_POINTS: usize = 2000;
/// Variances of the noise that are tried, in those of the torques.
const NOISES: [f64; 6] = [1e-4, 1e-3, 1e-2, 1e-1, 1.0, 10.0];
/// Samples of the validation trajectories that a choice is evaluated on.
const MAX_EVALUATED: usize = 4000;
/// Samples whose kernels are in memory at a time.
const ROWS: usize = 256;

/// A Gaussian process of states with the kernel exp(−|x − x'|²/2ℓ²), x in spreads, one for all joints; its mean.
///
/// # Reference
/// Rasmussen, Williams (2006), Gaussian processes for machine learning, (2.25); subset of data: section 8.3.3.
#[derive(Debug, Clone)]
pub struct GaussianProcess {
    n_joints: usize,
    units: StateUnits,
    /// [point][number of the state].
    points: Vec<f64>,
    length: f64,
    /// [point][joint], (K + σ² I)⁻¹ y.
    weights: Vec<f64>,
    /// Mean of every joint's targets.
    mean: Vec<f64>,
}

impl GaussianProcess {
    /// Conditioned on `rows` of `samples` with `targets` [sample][joint]; one process for each noise, whose variances are in those of
    /// the targets.
    fn conditioned(
        (samples, targets): (&ArmSamples, &[f64]),
        rows: &[usize],
        units: &StateUnits,
        length: f64,
        noises: &[f64],
    ) -> Vec<Self> {
        let (n, width) = (samples.n_joints, units.len());
        let mut points = vec![0.0; rows.len() * width];
        for (row, x) in rows.iter().zip(points.chunks_exact_mut(width)) {
            units.write(samples, *row, x);
        }
        let mut mean = vec![0.0; n];
        for row in rows {
            (0..n).for_each(|j| mean[j] += targets[n * row + j] / rows.len() as f64);
        }
        let centred: Vec<f64> = rows
            .iter()
            .flat_map(|row| (0..n).map(move |j| (row, j)))
            .map(|(row, j)| targets[n * row + j] - mean[j])
            .collect();
        let empty = Self { n_joints: n, units: units.clone(), points, length, weights: Vec::new(), mean };
        let mut kernel = vec![0.0; rows.len() * rows.len()];
        kernel.par_chunks_mut(rows.len()).enumerate().for_each(|(i, out)| {
            empty.kernels(&empty.points[i * width..(i + 1) * width], out);
        });
        let of = |noise: &f64| Self {
            weights: solve_positive_definite(&kernel, rows.len(), *noise, &centred),
            ..empty.clone()
        };
        noises.iter().map(of).collect()
    }

    /// Kernels of a state with every point.
    fn kernels(&self, x: &[f64], out: &mut [f64]) {
        let per = -0.5 / (self.length * self.length);
        for (point, k) in self.points.chunks_exact(x.len()).zip(out) {
            *k = (per * point.iter().zip(x).map(|(a, b)| (a - b) * (a - b)).sum::<f64>()).exp();
        }
    }

    /// How many samples it is conditioned on.
    pub fn n_points(&self) -> usize {
        self.points.len() / self.units.len()
    }

    /// Mean torques [sample][joint].
    pub fn predict(&self, samples: &ArmSamples) -> Vec<f64> {
        let (n, n_points) = (self.n_joints, self.n_points());
        let mut found = vec![0.0; samples.len() * n];
        found.par_chunks_mut(ROWS * n).enumerate().for_each(|(b, out)| {
            let mut kernels = vec![0.0; n_points * out.len() / n];
            let mut x = vec![0.0; self.units.len()];
            for (k, row) in kernels.chunks_exact_mut(n_points).enumerate() {
                self.units.write(samples, b * ROWS + k, &mut x);
                self.kernels(&x, row);
            }
            predict(&kernels, &self.weights, n_points, out);
            out.chunks_exact_mut(n).for_each(|row| row.iter_mut().zip(&self.mean).for_each(|(t, m)| *t += m));
        });
        found
    }
}

/// A Gaussian process with what validation chose; the penalty is the variance of the noise.
#[derive(Debug, Clone)]
pub struct GaussianFit {
    /// Conditioned on samples of all trajectories.
    pub process: GaussianProcess,
    /// The noise chosen, in variances.
    pub choice: Choice,
    /// The length chosen, in spreads of the states.
    pub length: f64,
}

/// Evenly spread samples of these trajectories, at most `most`.
fn spread(samples: &ArmSamples, trajectories: &[usize], most: usize) -> Vec<usize> {
    let all: Vec<usize> = trajectories.iter().flat_map(|t| samples.trajectories[*t].clone()).collect();
    all.iter().copied().step_by(all.len().div_ceil(most).max(1)).collect()
}

/// A Gaussian process of what `offset` (torques that another model predicts, [sample][joint]) leaves, conditioned on at most `most` samples,
/// evenly spread over the training data; length and noise are chosen on validation trajectories.
///
/// # Errors
/// `BadInput` for fewer than two trajectories, or no length.
pub fn fit_gaussian_process(
    training: &ArmSamples,
    offset: &[f64],
    lengths: &[f64],
    most: usize,
    continues: GoesOn<'_>,
) -> Result<Option<GaussianFit>, BadInput> {
    let n = training.n_joints;
    let spreads = training.deviations(&training.tau);
    // All joints share one kernel, so their torques are in units of their spread.
    let scaled = |tau: &[f64]| -> Vec<f64> {
        tau.iter().enumerate().map(|(i, t)| t / spreads[i % n].max(1e-12)).collect()
    };
    let left: Vec<f64> = training.tau.iter().zip(offset).map(|(t, o)| t - o).collect();
    let (targets, units) = (scaled(&left), StateUnits::new(training));
    let n_trajectories = training.trajectories.len();
    let folds = folds(n_trajectories, FOLDS.min(n_trajectories))?;
    let mut best: Option<(Choice, f64)> = None;
    for length in lengths {
        let mut errors = [0.0; NOISES.len()];
        for fold in &folds {
            if !continues() {
                return Ok(None);
            }
            let rows = spread(training, &fold.training, most);
            let processes =
                GaussianProcess::conditioned((training, &targets), &rows, &units, *length, &NOISES);
            let rows = spread(training, &fold.test, MAX_EVALUATED);
            let evaluated = training.rows(&rows);
            let rest: Vec<f64> =
                rows.iter().flat_map(|i| targets[n * i..n * (i + 1)].iter().copied()).collect();
            // Errors of what is left are errors of the torques; those are normalised by the variance of the torques themselves.
            let variances = evaluated.variances(&scaled(&evaluated.tau));
            for (process, error) in processes.iter().zip(&mut errors) {
                let scores = TorqueScores::of(n, &rest, &process.predict(&evaluated));
                let nmse = scores.mse.iter().zip(&variances).map(|(mse, variance)| mse / variance);
                *error += nmse.sum::<f64>() / (n * folds.len()) as f64;
            }
        }
        for (penalty, validation) in NOISES.into_iter().zip(errors) {
            if best.is_none_or(|(best, _)| validation < best.validation) {
                best = Some((Choice { penalty, validation }, *length));
            }
        }
    }
    let (choice, length) = best.ok_or_else(|| BadInput::new("lengths", "one or more", "none"))?;
    let rows = spread(training, &(0..n_trajectories).collect::<Vec<_>>(), most);
    let process =
        GaussianProcess::conditioned((training, &targets), &rows, &units, length, &[choice.penalty])
            .swap_remove(0);
    let back = |values: Vec<f64>| values.iter().enumerate().map(|(i, v)| v * spreads[i % n]).collect();
    let process = GaussianProcess {
        weights: back(process.weights.clone()),
        mean: back(process.mean.clone()),
        ..process
    };
    Ok(Some(GaussianFit { process, choice, length }))
}

#[cfg(test)]
#[allow(clippy::unwrap_used)] // a test may stop where it stands
mod tests {
    use super::*;
    use crate::baselines::{FourierFeatures, fit_fourier};
    use crate::lagrangian::{Sinusoids, sinusoids};
    use hysteron_arm_dynamics::Model;

    fn data(seed: u64) -> ArmSamples {
        let model = Model::builtin("three-link").unwrap();
        let plan = Sinusoids { duration: 2.0, ..Sinusoids::published(8) };
        sinusoids(&model, &plan, seed, "gaussian").0
    }

    #[test]
    fn it_is_the_limit_of_ridge_regression_on_many_fourier_features() {
        let (training, test) = (data(1), data(2));
        let rows: Vec<usize> = (0..training.len()).step_by(4).collect();
        let subset = training.rows(&rows);
        let units = StateUnits::new(&subset);
        let (length, noise) = (6.0, 1e-2);
        let all: Vec<usize> = (0..subset.len()).collect();
        let process = GaussianProcess::conditioned((&subset, &subset.tau), &all, &units, length, &[noise])
            .swap_remove(0);
        let exact = process.predict(&test);
        // The penalty of a mean of squares over n features of mean square 1 equivalent to that noise; the features' own constant is
        // hardly penalised, as the mean is not.
        let difference = |n_features: usize| {
            let features = FourierFeatures::new(&subset, n_features, length, 1);
            let mut sums = crate::baselines::NormalEquations::new(features.width(), 3);
            features
                .normal_equations(&subset, &subset.tau, 1)
                .iter()
                .for_each(|part| sums.add_scaled(part, 1.0));
            let weights = sums.solve(noise * n_features as f64 / subset.len() as f64);
            let close = features.predict(&weights, &test);
            let left: f64 = exact.iter().zip(&close).map(|(a, b)| (a - b).powi(2)).sum();
            (left / exact.iter().map(|a| a * a).sum::<f64>()).sqrt()
        };
        let [few, many] = [difference(150), difference(2400)];
        // The kernel of n features errs by 1/√n: sixteen times as many leave a quarter.
        assert!(many < 0.5 * few && many < 0.05, "{few} {many}");
    }

    #[test]
    fn what_validation_chooses_predicts_other_trajectories_as_fourier_features_do() {
        let (training, test) = (data(1), data(2));
        let zeros = vec![0.0; training.tau.len()];
        let fit = fit_gaussian_process(&training, &zeros, &[2.0, 6.0], 400, &mut || true).unwrap().unwrap();
        assert_eq!(fit.process.n_points(), 400);
        let nmse = |tau: &[f64]| TorqueScores::of(3, &test.tau, tau).sum_nmse();
        let fourier =
            fit_fourier(&training, &zeros, &[2.0, 6.0], (400, 2, 0), &mut || true).unwrap().unwrap();
        let [process, features] =
            [nmse(&fit.process.predict(&test)), nmse(&fourier.features.predict(&fourier.weights, &test))];
        assert!(process < 2.0 * features, "{process} {features}");
        // Given the torques themselves nothing is left to learn.
        let fit = fit_gaussian_process(&training, &training.tau, &[6.0], 100, &mut || true).unwrap().unwrap();
        assert!(fit.process.predict(&test).iter().all(|t| t.abs() < 1e-9));
    }

    #[test]
    fn a_single_trajectory_leaves_nothing_to_choose_by() {
        let one = data(1).select([0]);
        let offset = vec![0.0; one.tau.len()];
        let bad = fit_gaussian_process(&one, &offset, &[2.0], 10, &mut || true).unwrap_err();
        assert_eq!(bad.place, "folds");
    }
}
