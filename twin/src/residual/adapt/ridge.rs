//! Least squares with a prior and bounds, of a few parameters.

use hysteron_base::Bounds;
use nalgebra::{DMatrix, DVector};

/// JᵀJ and Jᵀr of some errors r + J p.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct GaussNewtonSystem {
    pub square: DMatrix<f64>,
    pub right: DVector<f64>,
}

impl GaussNewtonSystem {
    pub fn zeros(n: usize) -> Self {
        Self { square: DMatrix::zeros(n, n), right: DVector::zeros(n) }
    }

    /// Adds the errors `errors` with the columns of J.
    pub fn add(&mut self, errors: &[f64], columns: &[Vec<f64>]) {
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        for (k, column) in columns.iter().enumerate() {
            self.right[k] += dot(column, errors);
            for (l, other) in columns.iter().enumerate() {
                self.square[(k, l)] += dot(column, other);
            }
        }
    }

    /// The p in `bounds` with the least |r + J p|² + weight Σ (p / deviation)²: a parameter that would pass a bound
    /// stays at it, and the others are sought again.
    pub fn solve(&self, weight: f64, deviations: &[f64], bounds: &[Bounds]) -> Vec<f64> {
        let n = deviations.len();
        let mut held: Vec<Option<f64>> = vec![None; n];
        loop {
            let free: Vec<usize> = (0..n).filter(|&k| held[k].is_none()).collect();
            let mut found: Vec<f64> = held.iter().map(|value| value.unwrap_or(0.0)).collect();
            let square = DMatrix::from_fn(free.len(), free.len(), |a, b| {
                let prior = if a == b { weight / deviations[free[a]].powi(2) } else { 0.0 };
                self.square[(free[a], free[b])] + prior
            });
            let right = DVector::from_fn(free.len(), |a, _| {
                let of_held: f64 = (0..n).map(|l| self.square[(free[a], l)] * found[l]).sum();
                -self.right[free[a]] - of_held
            });
            // A prior makes it positive definite; where numbers are not finite nothing is found.
            let Some(solved) = square.cholesky().map(|factor| factor.solve(&right)) else {
                return vec![0.0; n];
            };
            free.iter().zip(&solved).for_each(|(&k, value)| found[k] = *value);
            let passes = |&&k: &&usize| !bounds[k].contains(found[k]);
            let Some(&passing) = free.iter().find(passes) else { return found };
            held[passing] = Some(bounds[passing].clamp(found[passing]));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WIDE: Bounds = Bounds { min: -10.0, max: 10.0 };

    /// Errors that p = (1, -2) explains.
    fn normal() -> GaussNewtonSystem {
        let columns = [vec![1.0, 2.0, 0.5, -1.0], vec![0.3, -1.0, 2.0, 0.7]];
        let errors: Vec<f64> = columns[0].iter().zip(&columns[1]).map(|(a, b)| -(a - 2.0 * b)).collect();
        let mut normal = GaussNewtonSystem::zeros(2);
        normal.add(&errors, &columns);
        normal
    }

    #[test]
    fn what_made_the_errors_is_found_and_a_heavy_prior_holds_it_back() {
        let found = normal().solve(1e-12, &[1.0; 2], &[WIDE; 2]);
        assert!((found[0] - 1.0).abs() < 1e-10 && (found[1] + 2.0).abs() < 1e-10, "{found:?}");
        let held = normal().solve(1e6, &[1.0; 2], &[WIDE; 2]);
        assert!(held.iter().all(|p| p.abs() < 1e-4), "{held:?}");
    }

    #[test]
    fn a_bound_is_active_and_the_others_minimise_the_rest() {
        let bounds = [WIDE, Bounds { min: 0.0, max: 10.0 }];
        let found = normal().solve(1e-12, &[1.0; 2], &bounds);
        assert_eq!(found[1], 0.0);
        // The slope of the first alone: -Jᵀr / JᵀJ.
        let alone = -normal().right[0] / normal().square[(0, 0)];
        assert!((found[0] - alone).abs() < 1e-10, "{found:?} {alone}");
    }
}
