//! Strokes as cubic polynomials of where the tip shall be: the inverse kinematics without memory.

use hysteron_base::BadInput;
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

use super::path_point::PathPoint;
use super::{Axes, Demonstration, TipPosition};

/// Monomials of x and y up to the third degree, then those that have z too.
const N_PLANAR: usize = 10;
const N_SPATIAL: usize = 20;
/// Weight of the penalty on the coefficients over the number of samples; positions are scaled to about 1.
const RIDGE: f64 = 1e-6;

/// Strokes as ridge regression on the cubic monomials of the tip's coordinates.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StaticRegression {
    /// Largest distance of a tip from the origin [m]: the length of 1 in the monomials.
    radius_m: f64,
    /// Coefficients of the monomials, by tendon [m].
    coefficients: Vec<Vec<f64>>,
}

impl StaticRegression {
    /// Fits all samples that were not filled in, in closed form. `paths` are smoothed, one for each demonstration.
    ///
    /// # Errors
    /// The tip never moves.
    pub fn new(
        axes: Axes,
        demonstrations: &[Demonstration],
        paths: &[Vec<PathPoint>],
    ) -> Result<Self, BadInput> {
        let distance = |[x, y, z]: TipPosition| x.hypot(y).hypot(z);
        let radius_m = paths.iter().flatten().map(|point| distance(point.position)).fold(0.0, f64::max);
        let n = n_monomials(axes);
        let n_tendons = demonstrations[0].n_tendons;
        let mut square = DMatrix::<f64>::zeros(n, n);
        let mut right = DMatrix::<f64>::zeros(n, n_tendons);
        let mut count = 0.0;
        for (one, path) in demonstrations.iter().zip(paths) {
            for (i, point) in path.iter().enumerate().filter(|(i, _)| !one.gap[*i]) {
                let row = DVector::from_column_slice(&monomials(point.position, radius_m)[..n]);
                square.syger(1.0, &row, &row, 1.0);
                for (k, stroke) in one.strokes_at(i).iter().enumerate() {
                    right.column_mut(k).axpy(*stroke, &row, 1.0);
                }
                count += 1.0;
            }
        }
        square.fill_upper_triangle_with_lower_triangle();
        let ridge = DMatrix::identity(n, n) * (RIDGE * count);
        let factor = if radius_m > 0.0 { (square + ridge).cholesky() } else { None };
        let factor = factor.ok_or_else(|| {
            BadInput::new(
                "recordings: tip_x_m, tip_y_m",
                "a tip that moves",
                format!("{radius_m} m of travel"),
            )
        })?;
        let solved = factor.solve(&right);
        let column = |k: usize| solved.column(k).iter().copied().collect();
        Ok(Self { radius_m, coefficients: (0..n_tendons).map(column).collect() })
    }

    /// Mean square error of each stroke on demonstrations with their smoothed paths, without samples that were
    /// filled in [mm²].
    pub(super) fn squares(&self, demonstrations: &[Demonstration], paths: &[Vec<PathPoint>]) -> Vec<f64> {
        let n = self.n_tendons();
        let (mut squares, mut strokes, mut count) = (vec![0.0; n], vec![0.0; n], 0.0);
        for (one, path) in demonstrations.iter().zip(paths) {
            for (i, point) in path.iter().enumerate().filter(|(i, _)| !one.gap[*i]) {
                self.strokes_into(point.position, &mut strokes);
                for ((sum, found), stroke) in squares.iter_mut().zip(&strokes).zip(one.strokes_at(i)) {
                    *sum += (1e3 * (found - stroke)).powi(2);
                }
                count += 1.0;
            }
        }
        squares.into_iter().map(|sum| sum / f64::max(count, 1.0)).collect()
    }

    /// Number of tendons.
    pub fn n_tendons(&self) -> usize {
        self.coefficients.len()
    }

    /// True where it has a coefficient for every monomial of these axes.
    pub(super) fn is_for(&self, axes: Axes) -> bool {
        self.coefficients.iter().all(|row| row.len() == n_monomials(axes))
    }

    /// Writes the strokes (n_tendons) [m] for a tip.
    pub fn strokes_into(&self, tip: TipPosition, strokes: &mut [f64]) {
        let monomials = monomials(tip, self.radius_m);
        for (stroke, row) in strokes.iter_mut().zip(&self.coefficients) {
            *stroke = row.iter().zip(&monomials).map(|(c, m)| c * m).sum();
        }
    }
}

fn n_monomials(axes: Axes) -> usize {
    match axes {
        Axes::Planar => N_PLANAR,
        Axes::Spatial => N_SPATIAL,
    }
}

#[rustfmt::skip] // a degree a line
fn monomials(tip: TipPosition, radius: f64) -> [f64; N_SPATIAL] {
    let [x, y, z] = tip.map(|c| c / radius);
    [
        1.0, x, y, x * x, x * y, y * y, x * x * x, x * x * y, x * y * y, y * y * y,
        z, x * z, y * z, x * x * z, x * y * z, y * y * z,
        z * z, x * z * z, y * z * z,
        z * z * z,
    ]
}
