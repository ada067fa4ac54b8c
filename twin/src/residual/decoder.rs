//! From the tip displacement that is missing to auxiliary strokes.

use hysteron_base::BadInput;
use nalgebra::{DMatrix, Matrix2, Matrix2xX, Matrix3x2, Vector2, Vector3};
use serde::{Deserialize, Serialize};

use super::linear::add_product;

/// The shortest strokes that move the tip by about a given displacement across the robot: s = D z, D = Ĝᵀ (Ĝ Ĝᵀ + γ
/// I)⁻¹.
///
/// Ĝ is the sensitivity G = ∂y/∂s in x and y as a smooth function of the primary strokes, quadratic, fitted to the
/// sensitivities of the identification. G itself jumps where a tendon goes slack, and strokes for one and the same
/// displacement would jump with it, which the tip does not.
///
/// Along the robot no strokes are asked for: tendons have no hold there. What moves the tip by a millimetre along a
/// bent body, by a hundredth along a straight one, moves its two ends against each other across by four times as
/// much, and by more than the millimetre where that does not cancel. What is missing along z is added to the tip.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StrokeDecoder {
    /// Lowest and highest stroke of each primary tendon in the fit [m]; others count as the nearest of them.
    ranges: Vec<[f64; 2]>,
    /// Ĝ (2 × n_aux, column by column) for each of the terms 1, v_k, v_k v_l (k ≤ l) of strokes v brought to [-1, 1]
    /// [-].
    coefficients: Vec<f64>,
}

/// Scratch of a [`StrokeDecoder`].
#[derive(Debug, Clone)]
pub(super) struct Decoding {
    terms: Vec<f64>,
    /// Ĝ.
    sensitivity: Matrix2xX<f64>,
}

/// γ over the mean of the squared rows of Ĝ [-].
const REGULARISATION: f64 = 1e-3;
/// Ridge of the fit over the number of samples: strokes that always go together leave terms undetermined.
const RIDGE: f64 = 1e-6;

fn n_terms(n_primary: usize) -> usize {
    1 + n_primary + n_primary * (n_primary + 1) / 2
}

impl StrokeDecoder {
    /// Fits Ĝ to the sensitivities of a robot with so many primary and auxiliary tendons: samples of primary strokes [m] and
    /// ∂tip/∂s (3 × n_aux) there [-]. `strokes` are all that were commanded, of which the ranges are taken.
    ///
    /// # Errors
    /// Sensitivities that are not finite.
    pub fn fit<'a>(
        [n_primary, n_aux]: [usize; 2],
        strokes: impl Iterator<Item = &'a [f64]>,
        samples: impl Iterator<Item = (&'a [f64], [Vec<f64>; 3])>,
    ) -> Result<Self, BadInput> {
        let mut ranges = vec![[f64::INFINITY, f64::NEG_INFINITY]; n_primary];
        for row in strokes {
            for ([low, high], &u) in ranges.iter_mut().zip(row) {
                (*low, *high) = (low.min(u), high.max(u));
            }
        }
        let mut decoder = Self { ranges, coefficients: Vec::new() };
        let n = n_terms(n_primary);
        let (mut normal, mut right) = (DMatrix::zeros(n, n), DMatrix::zeros(n, 2 * n_aux));
        let (mut terms, mut n_samples) = (Vec::with_capacity(n), 0.0);
        for (strokes, g) in samples {
            decoder.terms_into(strokes, &mut terms);
            add_product(&mut normal, 1.0, &terms);
            for (k, mut column) in right.column_iter_mut().enumerate() {
                let value = g[k % 2][k / 2];
                column.iter_mut().zip(&terms).for_each(|(sum, term)| *sum += value * term);
            }
            n_samples += 1.0;
        }
        normal.fill_upper_triangle_with_lower_triangle();
        normal += DMatrix::identity(n, n) * (RIDGE * n_samples);
        let solved = normal.cholesky().map(|factor| factor.solve(&right));
        let solved = solved.filter(|found| found.iter().all(|value| value.is_finite()));
        let found = solved.ok_or_else(|| BadInput::new("sensitivities", "finite numbers", "others"))?;
        decoder.coefficients = found.transpose().iter().copied().collect();
        Ok(decoder)
    }

    /// Whether it is one of a robot with so many tendons and auxiliary tendons.
    pub fn fits(&self, n_primary: usize, n_aux: usize) -> bool {
        self.ranges.len() == n_primary && self.coefficients.len() == n_terms(n_primary) * 2 * n_aux
    }

    fn terms_into(&self, primary: &[f64], terms: &mut Vec<f64>) {
        terms.clear();
        terms.push(1.0);
        for (stroke, [low, high]) in primary.iter().zip(&self.ranges) {
            let width = high - low;
            terms.push(if width > 0.0 { 2.0 * (stroke.clamp(*low, *high) - low) / width - 1.0 } else { 0.0 });
        }
        for k in 1..=primary.len() {
            for l in k..=primary.len() {
                terms.push(terms[k] * terms[l]);
            }
        }
    }

    /// Finds Ĝ for primary strokes; gives (Ĝ Ĝᵀ + γ I)⁻¹, zero where Ĝ is.
    fn linearise(&self, primary: &[f64], scratch: &mut Decoding) -> Matrix2<f64> {
        self.terms_into(primary, &mut scratch.terms);
        scratch.sensitivity.fill(0.0);
        let g = scratch.sensitivity.as_mut_slice();
        for (term, part) in scratch.terms.iter().zip(self.coefficients.chunks_exact(g.len())) {
            for (value, coefficient) in g.iter_mut().zip(part) {
                *value += term * coefficient;
            }
        }
        let mut square = Matrix2::zeros();
        for column in scratch.sensitivity.column_iter() {
            square += column * column.transpose();
        }
        let gamma = REGULARISATION * square.trace() / 2.0;
        (square + gamma * Matrix2::identity()).try_inverse().unwrap_or_else(Matrix2::zeros)
    }

    /// Writes the strokes D z (n_aux) [m] for a displacement in x and y [m] at these primary strokes (n_primary) [m].
    pub(super) fn strokes_into(
        &self,
        primary: &[f64],
        displacement: [f64; 2],
        scratch: &mut Decoding,
        strokes: &mut [f64],
    ) {
        let pull = self.linearise(primary, scratch) * Vector2::from(displacement);
        for (stroke, g) in strokes.iter_mut().zip(scratch.sensitivity.column_iter()) {
            *stroke = g.dot(&pull);
        }
    }

    /// Response of the tip to a unit displacement where the sensitivity is `sensitivity` (3 × n_aux), row by
    /// row (3 × 3) [-]: its strokes G D in x and y, and in z itself.
    pub(super) fn seen_by(
        &self,
        sensitivity: &[Vec<f64>; 3],
        primary: &[f64],
        scratch: &mut Decoding,
    ) -> [[f64; 3]; 3] {
        let inverse = self.linearise(primary, scratch);
        let estimates = scratch.sensitivity.column_iter().enumerate();
        let product = estimates.fold(Matrix3x2::zeros(), |sum, (k, estimate)| {
            sum + Vector3::from_fn(|a, _| sensitivity[a][k]) * estimate.transpose()
        });
        let gain = product * inverse;
        std::array::from_fn(|a| [gain[(a, 0)], gain[(a, 1)], if a == 2 { 1.0 } else { 0.0 }])
    }
}

impl Decoding {
    pub fn new(n_aux: usize) -> Self {
        Self { terms: Vec::new(), sensitivity: Matrix2xX::zeros(n_aux) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ĝ with a part that changes its sign with the first of two strokes, in the range ±1 mm.
    fn decoder() -> StrokeDecoder {
        // The difference of two virtual strokes moves the tip along x, their sum along y by half of what the first
        // primary stroke requires; the third does nothing.
        let constant = [1.0, 0.0, -1.0, 0.0, 0.0, 0.0];
        let first = [0.0, 0.5, 0.0, 0.5, 0.0, 0.0];
        let coefficients = [&constant[..], &first, &[0.0; 4 * 6]].concat();
        StrokeDecoder { ranges: vec![[-1e-3, 1e-3]; 2], coefficients }
    }

    #[test]
    fn a_displacement_comes_out_where_strokes_can_make_it() {
        let decoder = decoder();
        assert!(decoder.fits(2, 3) && !decoder.fits(2, 4));
        let mut scratch = Decoding::new(3);
        // Beyond the range counts as its end.
        for (primary, sign) in [([1e-3, 0.0], 1.0), ([-1e-3, 0.0], -1.0), ([-5e-3, 0.0], -1.0)] {
            let along = [0.3, 0.1, 0.0];
            let g = [vec![1.0, -1.0, 0.0], vec![0.5 * sign, 0.5 * sign, 0.0], along.to_vec()];
            let seen = decoder.seen_by(&g, &primary, &mut scratch);
            // γ over the smaller of the squares, 2 and 0.5.
            let tol = REGULARISATION * (2.5 / 2.0) / 0.5;
            for (a, row) in seen[..2].iter().enumerate() {
                for (c, found) in row.iter().enumerate() {
                    let expected = if a == c { 1.0 } else { 0.0 };
                    assert!((found - expected).abs() < tol, "{seen:?}");
                }
            }
            // Along the axis: what the strokes for x (half, -half) and y (sign, sign) do there, and itself.
            let expected = [0.5 * (0.3 - 0.1), sign * (0.3 + 0.1), 1.0];
            for (found, expected) in seen[2].iter().zip(expected) {
                assert!((found - expected).abs() < tol, "{seen:?}");
            }
            let mut strokes = [0.0; 3];
            decoder.strokes_into(&primary, [1e-3, 0.0], &mut scratch, &mut strokes);
            assert!((strokes[0] - 0.5e-3).abs() < 1e-6 && (strokes[1] + 0.5e-3).abs() < 1e-6, "{strokes:?}");
            assert_eq!(strokes[2], 0.0, "nobody moves what does not move");
        }
    }
}
