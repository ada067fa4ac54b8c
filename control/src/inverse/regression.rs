//! Strokes as cubic polynomials of where the tip shall be: the inverse kinematics without memory.

use hysteron_base::BadInput;
use nalgebra::{DMatrix, SMatrix, SVector};
use serde::{Deserialize, Serialize};

use super::Demonstration;
use super::smooth::PathPoint;

/// Monomials of x and y up to the third degree.
const N: usize = 10;
/// Weight of the penalty on the coefficients over the number of samples; positions are scaled to about 1.
const RIDGE: f64 = 1e-6;

/// Strokes as ridge regression on the cubic monomials of the tip's x and y.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StaticRegression {
    /// Largest distance of a tip from the origin [m]: the length of 1 in the monomials.
    radius_m: f64,
    /// Coefficients of the monomials, by tendon [m].
    coefficients: Vec<[f64; N]>,
}

impl StaticRegression {
    /// Fits all samples that were not filled in, in closed form. `paths` are smoothed, one for each demonstration.
    ///
    /// # Errors
    /// The tip never moves.
    pub fn new(demonstrations: &[Demonstration], paths: &[Vec<PathPoint>]) -> Result<Self, BadInput> {
        let radius_m = paths.iter().flatten().map(|p| p.position[0].hypot(p.position[1])).fold(0.0, f64::max);
        let n_tendons = demonstrations[0].n_tendons;
        let mut square = SMatrix::<f64, N, N>::zeros();
        let mut right = DMatrix::<f64>::zeros(N, n_tendons);
        let mut count = 0.0;
        for (one, path) in demonstrations.iter().zip(paths) {
            for (i, point) in path.iter().enumerate().filter(|(i, _)| !one.gap[*i]) {
                let row = SVector::from(monomials(point.position, radius_m));
                square.syger(1.0, &row, &row, 1.0);
                for (k, stroke) in one.strokes_at(i).iter().enumerate() {
                    right.column_mut(k).axpy(*stroke, &row, 1.0);
                }
                count += 1.0;
            }
        }
        square.fill_upper_triangle_with_lower_triangle();
        let factor =
            if radius_m > 0.0 { (square + SMatrix::identity() * (RIDGE * count)).cholesky() } else { None };
        let factor = factor.ok_or_else(|| {
            BadInput::new(
                "recordings: tip_x_m, tip_y_m",
                "a tip that moves",
                format!("{radius_m} m of travel"),
            )
        })?;
        let solved = factor.solve(&right);
        let column = |k: usize| std::array::from_fn(|j| solved[(j, k)]);
        Ok(Self { radius_m, coefficients: (0..n_tendons).map(column).collect() })
    }

    /// Number of tendons.
    pub fn n_tendons(&self) -> usize {
        self.coefficients.len()
    }

    /// Writes the strokes (n_tendons) [m] for a tip [m].
    pub fn strokes_into(&self, tip: [f64; 2], strokes: &mut [f64]) {
        let monomials = monomials(tip, self.radius_m);
        for (stroke, row) in strokes.iter_mut().zip(&self.coefficients) {
            *stroke = row.iter().zip(&monomials).map(|(c, m)| c * m).sum();
        }
    }
}

fn monomials([x, y]: [f64; 2], radius: f64) -> [f64; N] {
    let (x, y) = (x / radius, y / radius);
    [1.0, x, y, x * x, x * y, y * y, x * x * x, x * x * y, x * y * y, y * y * y]
}
