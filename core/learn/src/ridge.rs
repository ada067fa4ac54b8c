//! Linear least squares with a penalty from sums over samples: what any network has to beat.

use faer::linalg::solvers::Solve;
use faer::{Mat, Side};

use crate::product::{multiply, multiply_add, rows};

/// XᵀX, XᵀY and the number of rows: all that a fit needs of its samples, which can be added and subtracted in
/// parts.
#[derive(Debug, Clone, PartialEq)]
pub struct NormalEquations {
    n_features: usize,
    n_outputs: usize,
    gram: Vec<f64>,
    moments: Vec<f64>,
    n_rows: usize,
}

impl NormalEquations {
    /// Of no samples.
    pub fn new(n_features: usize, n_outputs: usize) -> Self {
        let (gram, moments) = (vec![0.0; n_features * n_features], vec![0.0; n_features * n_outputs]);
        Self { n_features, n_outputs, gram, moments, n_rows: 0 }
    }

    /// Adds rows of features ([row][feature]) and outputs ([row][output]).
    pub fn add(&mut self, features: &[f64], outputs: &[f64]) {
        let (p, m) = (self.n_features, self.n_outputs);
        let (x, y) = (rows(features, p), rows(outputs, m));
        multiply_add(&mut self.gram, x.transpose(), x);
        multiply_add(&mut self.moments, x.transpose(), y);
        self.n_rows += x.nrows();
    }

    /// Adds `factor` (1 or −1) times the sums of other samples.
    pub fn add_scaled(&mut self, other: &Self, factor: f64) {
        let pairs = self.gram.iter_mut().zip(&other.gram).chain(self.moments.iter_mut().zip(&other.moments));
        for (sum, v) in pairs {
            *sum += factor * v;
        }
        self.n_rows = if factor > 0.0 { self.n_rows + other.n_rows } else { self.n_rows - other.n_rows };
    }

    /// XᵀX, row by row.
    pub fn gram(&self) -> &[f64] {
        &self.gram
    }

    /// XᵀY, row by row.
    pub fn moments(&self) -> &[f64] {
        &self.moments
    }

    /// Weights ([feature][output]) that minimise |X w − y|²/rows + λ |D w|², with D² the mean squares of the features.
    /// Features that are always zero get the weight zero.
    pub fn solve(&self, lambda: f64) -> Vec<f64> {
        let (p, m) = (self.n_features, self.n_outputs);
        let rows = self.n_rows.max(1) as f64;
        let scale: Vec<f64> = (0..p).map(|i| (self.gram[i * p + i] / rows).sqrt()).collect();
        let per = |i: usize| if scale[i] > 0.0 { 1.0 / scale[i] } else { 0.0 };
        let matrix = Mat::from_fn(p, p, |i, j| {
            let penalty = if i == j { lambda + if scale[i] > 0.0 { 0.0 } else { 1.0 } } else { 0.0 };
            self.gram[i * p + j] * per(i) * per(j) / rows + penalty
        });
        let right = Mat::from_fn(p, m, |i, k| self.moments[i * m + k] * per(i) / rows);
        let solution = solved(&matrix, &right);
        (0..p).flat_map(|i| (0..m).map(move |k| (i, k))).map(|(i, k)| solution[(i, k)] * per(i)).collect()
    }
}

/// Rounding can leave a matrix that is singular but for the penalty: then by the factor that pivots.
fn solved(matrix: &Mat<f64>, right: &Mat<f64>) -> Mat<f64> {
    match matrix.llt(Side::Lower) {
        Ok(factor) => factor.solve(right),
        Err(_) => matrix.partial_piv_lu().solve(right),
    }
}

/// Weights ([row][output]) of (A + λ I) w = y for a symmetric matrix A of size `n` whose eigenvalues are not negative, and y [row][output].
pub fn solve_positive_definite(matrix: &[f64], n: usize, lambda: f64, right: &[f64]) -> Vec<f64> {
    let m = right.len() / n;
    let matrix = Mat::from_fn(n, n, |i, j| matrix[i * n + j] + if i == j { lambda } else { 0.0 });
    let right = Mat::from_fn(n, m, |i, k| right[i * m + k]);
    let solution = solved(&matrix, &right);
    (0..n).flat_map(|i| (0..m).map(move |k| (i, k))).map(|(i, k)| solution[(i, k)]).collect()
}

/// Outputs ([row][output]) for rows of features.
pub fn predict(features: &[f64], weights: &[f64], n_features: usize, out: &mut [f64]) {
    multiply(out, rows(features, n_features), rows(weights, weights.len() / n_features));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_of_a_linear_law_come_back_and_a_penalty_shrinks_them() {
        let features: Vec<f64> = (0..60).map(|i| (0.37 * f64::from(i * i)).sin()).collect();
        let truth = [1.5, -0.5, 2.0];
        let outputs: Vec<f64> =
            features.chunks(3).map(|x| x.iter().zip(truth).map(|(x, w)| x * w).sum()).collect();
        let mut sums = NormalEquations::new(3, 1);
        sums.add(&features[..30], &outputs[..10]);
        sums.add(&features[30..], &outputs[10..]);
        for (found, exact) in sums.solve(0.0).iter().zip(truth) {
            assert!((found - exact).abs() < 1e-12, "{found} {exact}");
        }
        let size = |w: &[f64]| w.iter().map(|w| w * w).sum::<f64>();
        assert!(size(&sums.solve(1.0)) < 0.5 * size(&truth));
        let mut half = sums.clone();
        let mut other = NormalEquations::new(3, 1);
        other.add(&features[30..], &outputs[10..]);
        half.add_scaled(&other, -1.0);
        let mut first = NormalEquations::new(3, 1);
        first.add(&features[..30], &outputs[..10]);
        assert!(half.gram.iter().zip(&first.gram).all(|(a, b)| (a - b).abs() < 1e-13));
    }

    #[test]
    fn a_feature_that_is_always_zero_gets_no_weight() {
        let mut sums = NormalEquations::new(2, 1);
        sums.add(&[1.0, 0.0, 2.0, 0.0], &[2.0, 4.0]);
        assert_eq!(sums.solve(0.0), vec![2.0, 0.0]);
    }
}
