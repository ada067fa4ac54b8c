//! The tip as an effector: where it is, how it is turned, and what tensions do to both.

use nalgebra::{DMatrix, DVector, Matrix3, Rotation3, UnitQuaternion, Vector3};

use crate::alignment::nearest_rotation;
use crate::model::Twin;
use crate::projection::Projection;
use crate::state::TwinState;

impl Twin {
    /// Position of the tip [m].
    pub fn tip_of(&self, state: &TwinState) -> [f64; 3] {
        self.tip.at(&state.positions)
    }

    /// Rotation of the tip since rest: the one that brings its nodes' arms closest to what they are now (least
    /// squares).
    pub fn tip_rotation_of(&self, state: &TwinState) -> UnitQuaternion<f64> {
        let (rest, now) = (self.tip_arms(&self.body.rest), self.tip_arms(&state.positions));
        let covariance: Matrix3<f64> = rest.iter().zip(&now).map(|(rest, now)| now * rest.transpose()).sum();
        UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(nearest_rotation(&covariance)))
    }

    /// From the tip to each of its nodes [m].
    fn tip_arms(&self, positions: &[[f64; 4]]) -> Vec<Vector3<f64>> {
        let center = Vector3::from(self.tip.at(positions));
        self.tip.nodes.iter().map(|&node| at(positions, node) - center).collect()
    }

    /// What the unit tension of each cable does to the tip: three rows of displacement [m/N], one column per
    /// cable.
    pub(crate) fn tip_displacement_rows(&self, projection: &Projection) -> [Vec<f64>; 3] {
        std::array::from_fn(|c| {
            let along = |column: &Vec<f64>| {
                let carriers = self.tip.nodes.iter().zip(&self.tip.weights);
                carriers.map(|(&node, weight)| weight * moved(column, node)[c]).sum()
            };
            projection.columns.iter().map(along).collect()
        })
    }

    /// What a change of each `held` stroke does to the tip while the others stay, ∂y/∂s = W_e,h W_h,h⁻¹: three rows of
    /// displacement [-], one column per held cable. `None` where held cables pull the same way.
    pub(crate) fn tip_per_held_stroke(
        &self,
        projection: &Projection,
        held: &[usize],
    ) -> Option<[Vec<f64>; 3]> {
        let (n, n_cables) = (held.len(), projection.columns.len());
        let among = DMatrix::from_fn(n, n, |a, b| projection.delassus[held[a] * n_cables + held[b]]);
        let factor = among.cholesky()?;
        let per_tension = self.tip_displacement_rows(projection);
        let row = |row: &Vec<f64>| factor.solve(&DVector::from_fn(n, |a, _| row[held[a]]));
        Some(per_tension.each_ref().map(|one| row(one).iter().copied().collect()))
    }

    /// What the unit tension of each cable does to the tip's orientation: three rows of the rotation vector, in
    /// space [rad/N]. The derivative of [`Self::tip_rotation_of`] for a tip that keeps its form.
    pub(crate) fn tip_rotation_rows(&self, projection: &Projection, state: &TwinState) -> [Vec<f64>; 3] {
        let arms = self.tip_arms(&state.positions);
        let square: Matrix3<f64> =
            arms.iter().map(|arm| Matrix3::identity() * arm.norm_squared() - arm * arm.transpose()).sum();
        let inverse = square.try_inverse().unwrap_or_else(Matrix3::zeros);
        let turn = |column: &Vec<f64>| -> Vector3<f64> {
            let nodes = self.tip.nodes.iter().zip(&arms);
            inverse * nodes.map(|(&node, arm)| arm.cross(&moved(column, node))).sum::<Vector3<f64>>()
        };
        let turns: Vec<Vector3<f64>> = projection.columns.iter().map(turn).collect();
        std::array::from_fn(|c| turns.iter().map(|turn| turn[c]).collect())
    }
}

fn at(positions: &[[f64; 4]], node: u32) -> Vector3<f64> {
    let [x, y, z, _] = positions[node as usize];
    Vector3::new(x, y, z)
}

/// Displacement of a node; clamped ones come after the free unknowns and do not move.
fn moved(column: &[f64], node: u32) -> Vector3<f64> {
    let first = 3 * node as usize;
    column.get(first..first + 3).map_or_else(Vector3::zeros, Vector3::from_column_slice)
}
