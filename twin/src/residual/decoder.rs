//! From the tip displacement that is missing to auxiliary strokes.

use hysteron_base::BadInput;
use nalgebra::{DMatrix, Matrix3};
use serde::{Deserialize, Serialize};

/// The shortest strokes that move the tip by a given displacement in the middle of what was identified:
/// s = D z, D = Ḡᵀ (Ḡ Ḡᵀ)⁻¹ with the mean sensitivity Ḡ = ∂y/∂s.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Decoder {
    /// D (n_aux × 3), row by row [-].
    rows: Vec<[f64; 3]>,
}

impl Decoder {
    /// For a mean sensitivity (3 × n_aux, row by row) [-].
    ///
    /// # Errors
    /// Auxiliary tendons that cannot move the tip in all three directions.
    pub fn new(sensitivity: &[Vec<f64>; 3]) -> Result<Self, BadInput> {
        let n = sensitivity[0].len();
        let g = DMatrix::from_fn(3, n, |c, k| sensitivity[c][k]);
        let square = Matrix3::from_fn(|a, b| g.row(a).dot(&g.row(b)));
        let inverse = square.try_inverse().filter(|inverse| inverse.iter().all(|x| x.is_finite()));
        let inverse = inverse.ok_or_else(|| {
            BadInput::new("auxiliary tendons", "some that move the tip in x, y and z", "none for one of them")
                .hint("a layout needs cables around the axis, in more than one plane")
        })?;
        let row = |k: usize| std::array::from_fn(|c| (0..3).map(|a| g[(a, k)] * inverse[(a, c)]).sum());
        Ok(Self { rows: (0..n).map(row).collect() })
    }

    /// Number of auxiliary tendons.
    pub fn n_aux(&self) -> usize {
        self.rows.len()
    }

    /// Writes the strokes (n_aux) [m] for a displacement [m].
    pub fn strokes_into(&self, displacement: [f64; 3], strokes: &mut [f64]) {
        for (stroke, row) in strokes.iter_mut().zip(&self.rows) {
            *stroke = (0..3).map(|c| row[c] * displacement[c]).sum();
        }
    }

    /// What strokes of a unit displacement do to the tip under another sensitivity (3 × n_aux): G D, row by row.
    pub fn seen_by(&self, sensitivity: &[Vec<f64>; 3]) -> [[f64; 3]; 3] {
        std::array::from_fn(|a| {
            std::array::from_fn(|c| self.rows.iter().zip(&sensitivity[a]).map(|(row, g)| g * row[c]).sum())
        })
    }
}
