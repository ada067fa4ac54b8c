//! Levenberg and Marquardt's method for networks of some thousand parameters: it finds digits that first-order methods and L-BFGS do not.
//!
//! The mean of squared residuals has the gradient 2 Jᵀr and, near its minimum, the second derivatives 2 JᵀJ. A step solves
//! (JᵀJ + λ I) δ = −Jᵀr. The gradient is that of all samples, JᵀJ that of a part of them, redrawn for every step: the step is a
//! descent direction of the whole sum for any part, and no step is taken that does not lower the whole sum.

use faer::linalg::matmul::triangular::{BlockStructure, matmul as triangular_matmul};
use faer::linalg::solvers::Solve;
use faer::{Accum, Col, Mat, MatMut, MatRef, Par, Side};
use hysteron_base::rng;
use rand::RngExt;
use rayon::prelude::*;

use super::{Ending, Objective};

/// An objective that is the mean over samples of a sum of squares.
pub trait LeastSquares: Objective<f64> {
    /// Residuals of a sample.
    fn n_residuals(&self) -> usize;

    /// Writes the derivatives of these samples' residuals: [sample][residual][parameter].
    fn jacobian(&mut self, parameters: &[f64], samples: &[usize], jacobian: &mut [f64]);
}

/// The optimiser and its settings.
///
/// # Reference
/// Nocedal, Wright (2006), Numerical optimization, section 10.3; the damping follows Nielsen (1999), Damping parameter in Marquardt's method,
/// IMM-REP-1999-05, eq. 2.5.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LevenbergMarquardt {
    /// Steps at most.
    pub iterations: usize,
    /// Samples that JᵀJ of a step is of.
    pub batch: usize,
    /// λ at the start, over the mean diagonal of JᵀJ.
    pub damping: f64,
}

/// Samples whose Jacobian is held at once.
const ROWS: usize = 256;
/// Columns of JᵀJ that one thread adds to.
const PANEL: usize = 128;
/// Dampings of one step that are tried.
const MAX_TRIALS: usize = 12;

impl LevenbergMarquardt {
    /// Parameters up to which it is for: two square matrices of that size are held, a gigabyte.
    pub const MAX_PARAMETERS: usize = 8000;

    /// Minimises the mean over `samples` from `x` on, in place. `after(step, value, x)` is called at every step and ends the search
    /// where it returns false.
    pub fn minimise(
        &self,
        objective: &mut dyn LeastSquares,
        samples: &[usize],
        seed: u64,
        x: &mut Vec<f64>,
        after: &mut dyn FnMut(usize, f64, &[f64]) -> bool,
    ) -> (f64, Ending) {
        let n = x.len();
        let mut rng = rng(seed, "learn/levenberg-marquardt");
        let mut normal = vec![0.0; n * n];
        let mut gradient = vec![0.0; n];
        let mut value = objective.gradient(x, samples, &mut gradient);
        let (mut damping, mut growth) = (None, 2.0);
        for step in 1..=self.iterations {
            let drawn: Vec<usize> = if self.batch >= samples.len() {
                samples.to_vec()
            } else {
                (0..self.batch).map(|_| samples[rng.random_range(0..samples.len())]).collect()
            };
            normal_matrix(objective, x, &drawn, &mut normal);
            let mean = (0..n).map(|i| normal[i * n + i]).sum::<f64>() / n as f64;
            let mut lambda = damping.unwrap_or(self.damping * mean);
            let mut found = None;
            for _ in 0..MAX_TRIALS {
                if let Some(direction) = solve(&normal, &gradient, lambda) {
                    let trial: Vec<f64> = x.iter().zip(&direction).map(|(x, d)| x + d).collect();
                    let mut after = vec![0.0; n];
                    let reached = objective.gradient(&trial, samples, &mut after);
                    // What the quadratic model promises: -gᵀδ − δᵀJᵀJδ = δᵀ(λ δ − g/2).
                    let promised: f64 =
                        direction.iter().zip(&gradient).map(|(d, g)| d * (lambda * d - 0.5 * g)).sum();
                    if reached < value {
                        let ratio = (value - reached) / promised;
                        lambda *= (1.0 - (2.0 * ratio - 1.0).powi(3)).clamp(1.0 / 3.0, 2.0);
                        growth = 2.0;
                        found = Some((trial, reached, after));
                        break;
                    }
                }
                lambda *= growth;
                growth *= 2.0;
            }
            damping = Some(lambda);
            let Some(found) = found else { return (value, Ending::NoProgress) };
            (*x, value, gradient) = found;
            if !after(step, value, x) {
                return (value, Ending::Stopped);
            }
        }
        (value, Ending::Iterations)
    }
}

/// JᵀJ over the number of samples; its lower triangle, column by column.
fn normal_matrix(objective: &mut dyn LeastSquares, x: &[f64], samples: &[usize], normal: &mut [f64]) {
    let n = x.len();
    let per_sample = 1.0 / samples.len() as f64;
    normal.fill(0.0);
    let mut jacobian = Vec::new();
    for samples in samples.chunks(ROWS) {
        jacobian.clear();
        jacobian.resize(samples.len() * objective.n_residuals() * n, 0.0);
        objective.jacobian(x, samples, &mut jacobian);
        let j = MatRef::from_row_major_slice(&jacobian, jacobian.len() / n, n);
        // Every panel is added to by one thread: the sums do not depend on how many there are.
        normal.par_chunks_mut(PANEL * n).enumerate().for_each(|(panel, values)| {
            let first = panel * PANEL;
            let width = values.len() / n;
            let panel = MatMut::from_column_major_slice_mut(values, n, width);
            let (_, below) = panel.split_at_row_mut(first);
            let (square, below) = below.split_at_row_mut(width);
            let right = j.subcols(first, width);
            let whole = BlockStructure::Rectangular;
            triangular_matmul(
                square,
                BlockStructure::TriangularLower,
                Accum::Add,
                right.transpose(),
                whole,
                right,
                whole,
                per_sample,
                Par::Seq,
            );
            let left = j.subcols(first + width, n - first - width).transpose();
            faer::linalg::matmul::matmul(below, Accum::Add, left, right, per_sample, Par::Seq);
        });
    }
}

/// −(JᵀJ + λ I)⁻¹ g/2; none where the matrix is not positive definite to rounding.
fn solve(normal: &[f64], gradient: &[f64], lambda: f64) -> Option<Vec<f64>> {
    let n = gradient.len();
    let mut matrix: Mat<f64> = MatRef::from_column_major_slice(normal, n, n).to_owned();
    (0..n).for_each(|i| matrix[(i, i)] += lambda);
    let right = Col::from_fn(n, |i| -0.5 * gradient[i]);
    let found = matrix.llt(Side::Lower).ok()?.solve(&right);
    let found: Vec<f64> = found.iter().copied().collect();
    found.iter().all(|v| v.is_finite()).then_some(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// y = a exp(b t) at some times, without noise.
    struct Decay {
        samples: Vec<[f64; 2]>,
    }

    impl Decay {
        fn new() -> Self {
            let sample = |k: u32| {
                let t = 0.1 * f64::from(k);
                [t, 2.0 * (-1.5 * t).exp()]
            };
            Self { samples: (0..30).map(sample).collect() }
        }

        fn residual(&self, x: &[f64], sample: usize) -> (f64, [f64; 2]) {
            let [t, y] = self.samples[sample];
            let e = (x[1] * t).exp();
            (x[0] * e - y, [e, x[0] * t * e])
        }
    }

    impl Objective<f64> for Decay {
        fn n_samples(&self) -> usize {
            self.samples.len()
        }

        fn gradient(&mut self, x: &[f64], samples: &[usize], gradient: &mut [f64]) -> f64 {
            gradient.fill(0.0);
            let per_sample = 1.0 / samples.len() as f64;
            let mut sum = 0.0;
            for (r, by_x) in samples.iter().map(|s| self.residual(x, *s)) {
                sum += per_sample * r * r;
                (0..2).for_each(|i| gradient[i] += 2.0 * per_sample * r * by_x[i]);
            }
            sum
        }

        fn validate(&mut self, _: &[f64]) -> f64 {
            0.0
        }
    }

    impl LeastSquares for Decay {
        fn n_residuals(&self) -> usize {
            1
        }

        fn jacobian(&mut self, x: &[f64], samples: &[usize], jacobian: &mut [f64]) {
            for (row, sample) in jacobian.chunks_exact_mut(2).zip(samples) {
                row.copy_from_slice(&self.residual(x, *sample).1);
            }
        }
    }

    #[test]
    fn a_curve_is_found_to_rounding_with_the_second_derivatives_of_all_samples_or_of_some() {
        let all: Vec<usize> = (0..30).collect();
        for batch in [30, 10] {
            let method = LevenbergMarquardt { iterations: 60, batch, damping: 1e-3 };
            let mut x = vec![1.0, 0.0];
            let (value, _) = method.minimise(&mut Decay::new(), &all, 3, &mut x, &mut |_, _, _| true);
            assert!(value < 1e-24 && (x[0] - 2.0).abs() < 1e-11, "{batch}: {x:?} {value}");
        }
    }

    #[test]
    fn every_step_lowers_the_sum_and_it_stops_on_request() {
        let all: Vec<usize> = (0..30).collect();
        let method = LevenbergMarquardt { iterations: 60, batch: 4, damping: 1e-6 };
        let mut values = Vec::new();
        let mut x = vec![9.0, 3.0];
        let (_, ending) = method.minimise(&mut Decay::new(), &all, 1, &mut x, &mut |step, value, _| {
            values.push(value);
            step < 8
        });
        assert_eq!((ending, values.len()), (Ending::Stopped, 8));
        assert!(values.windows(2).all(|pair| pair[1] < pair[0]), "{values:?}");
    }

    #[test]
    fn the_normal_matrix_is_that_of_the_definition_for_any_size() {
        // More parameters than a panel has columns, more samples than are held at once.
        struct Linear(usize);
        impl Objective<f64> for Linear {
            fn n_samples(&self) -> usize {
                ROWS + 3
            }
            fn gradient(&mut self, _: &[f64], _: &[usize], _: &mut [f64]) -> f64 {
                0.0
            }
            fn validate(&mut self, _: &[f64]) -> f64 {
                0.0
            }
        }
        let entry = |sample: usize, i: usize| f64::from(((7 * sample + 13 * i) % 11) as u32) - 5.0;
        impl LeastSquares for Linear {
            fn n_residuals(&self) -> usize {
                1
            }
            fn jacobian(&mut self, _: &[f64], samples: &[usize], jacobian: &mut [f64]) {
                for (row, sample) in jacobian.chunks_exact_mut(self.0).zip(samples) {
                    let value = |i: usize| f64::from(((7 * sample + 13 * i) % 11) as u32) - 5.0;
                    row.iter_mut().enumerate().for_each(|(i, v)| *v = value(i));
                }
            }
        }
        let n = PANEL + 5;
        let samples: Vec<usize> = (0..ROWS + 3).collect();
        let mut normal = vec![0.0; n * n];
        normal_matrix(&mut Linear(n), &vec![0.0; n], &samples, &mut normal);
        for column in 0..n {
            for row in column..n {
                let sum: f64 = samples.iter().map(|s| entry(*s, row) * entry(*s, column)).sum();
                let found = normal[column * n + row];
                assert!((found - sum / samples.len() as f64).abs() < 1e-12, "{row} {column}");
            }
        }
    }
}
