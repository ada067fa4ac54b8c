//! From the tip displacement that is missing to auxiliary strokes.

use nalgebra::{DMatrix, Matrix3};
use serde::{Deserialize, Serialize};

/// The shortest strokes that move the tip by about a given displacement: s = D z, D = Gᵀ (G Gᵀ + γ I)⁻¹ with the sensitivity
/// G = ∂y/∂s of the present shape. What a stroke does along the axis changes its sign between a straight and a bent body:
/// a mean of G would do there what nobody asked for. Where the tip hardly moves along an axis, γ asks for little.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Decoder {
    /// γ over the mean of the squared rows of G [-].
    pub regularisation: f64,
}

impl Decoder {
    /// D (n_aux × 3, row by row) for a sensitivity (3 × n_aux) [-]; nothing moves where G is zero.
    pub fn rows(&self, sensitivity: &[Vec<f64>; 3]) -> Vec<[f64; 3]> {
        let n = sensitivity[0].len();
        let g = DMatrix::from_fn(3, n, |c, k| sensitivity[c][k]);
        let square = Matrix3::from_fn(|a, b| g.row(a).dot(&g.row(b)));
        let gamma = self.regularisation * square.trace() / 3.0;
        let inverse = (square + gamma * Matrix3::identity()).try_inverse().unwrap_or_else(Matrix3::zeros);
        let row = |k: usize| std::array::from_fn(|c| (0..3).map(|a| g[(a, k)] * inverse[(a, c)]).sum());
        (0..n).map(row).collect()
    }

    /// What strokes for a unit displacement do to the tip: G D, row by row.
    pub fn seen_by(&self, sensitivity: &[Vec<f64>; 3]) -> [[f64; 3]; 3] {
        let rows = self.rows(sensitivity);
        std::array::from_fn(|a| {
            std::array::from_fn(|c| rows.iter().zip(&sensitivity[a]).map(|(row, g)| g * row[c]).sum())
        })
    }
}

/// Writes the strokes D z (n_aux) [m] for a displacement [m].
pub(super) fn strokes_into(rows: &[[f64; 3]], displacement: [f64; 3], strokes: &mut [f64]) {
    for (stroke, row) in strokes.iter_mut().zip(rows) {
        *stroke = (0..3).map(|c| row[c] * displacement[c]).sum();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_displacement_comes_out_where_strokes_can_make_it() {
        let decoder = Decoder { regularisation: 1e-6 };
        // Two strokes that both move the tip along z can make it in x and z, and not at all in y.
        let g = [vec![1.0, -1.0, 0.0], vec![0.0; 3], vec![0.5, 0.5, 0.0]];
        let seen = decoder.seen_by(&g);
        for (a, row) in seen.iter().enumerate() {
            for (c, found) in row.iter().enumerate() {
                let expected = if a == c && a != 1 { 1.0 } else { 0.0 };
                // γ = 1e-6 · 2.5/3 over squares of 2 and 0.5.
                assert!((found - expected).abs() < 2e-6, "{seen:?}");
            }
        }
        assert!(decoder.rows(&g).iter().all(|row| row[1] == 0.0), "nobody moves what does not move");
        assert!(
            decoder.rows(&[vec![0.0; 3], vec![0.0; 3], vec![0.0; 3]]).iter().flatten().all(|d| *d == 0.0)
        );
    }
}
