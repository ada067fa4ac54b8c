//! The tip as an effector: where it is, how it is turned, and what tensions do to both; all in the frame in which
//! tips are recorded.

use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};

use crate::alignment::nearest_rotation;
use crate::model::Twin;
use crate::projection::Projection;
use crate::state::TwinState;

/// Response of the tip to small changes at the twin's state.
#[derive(Debug, Clone, PartialEq)]
pub struct TipResponse {
    /// Of each primary stroke, ∂y/∂s (3 × n_primary) [-]: zero for a slack tendon or one driven by tension.
    pub per_stroke: [Vec<f64>; 3],
    /// Of a force on the tip while strokes are held, ∂y/∂F (3 × 3, symmetric) [m/N].
    pub per_force: [[f64; 3]; 3],
}

impl Twin {
    /// Position of the tip, in the frame in which it is recorded [m].
    pub fn tip_of(&self, state: &TwinState) -> [f64; 3] {
        let at = match &self.chain {
            Some(chain) => chain.tip_of(state),
            None => self.tip.at(&state.positions),
        };
        self.tracker.point(at)
    }

    /// Rotation of the tip since rest, in the frame in which it is recorded: the one that brings its nodes' arms
    /// closest to what they are now (least squares); of a chain that of its last interface.
    pub fn tip_rotation_of(&self, state: &TwinState) -> UnitQuaternion<f64> {
        let rotation = match state.interfaces.last() {
            Some(last) => self.tracker.turn * last.rotation * self.tracker.turn.transpose(),
            None => {
                let (rest, now) = (self.tip_arms(&self.body.rest), self.tip_arms(&state.positions));
                nearest_rotation(&rest.iter().zip(&now).map(|(rest, now)| now * rest.transpose()).sum())
            }
        };
        UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(rotation))
    }

    /// From the tip to each of its nodes, as recorded [m].
    fn tip_arms(&self, positions: &[[f64; 4]]) -> Vec<Vector3<f64>> {
        let center = Vector3::from(self.tip.at(positions));
        self.tip.nodes.iter().map(|&node| self.tracker.turn * (at(positions, node) - center)).collect()
    }

    /// Displacement of the tip by the unit tension of each cable: three rows [m/N], one column per cable (3 ×
    /// n_cables).
    pub(crate) fn tip_displacement_rows(&self, projection: &Projection) -> [Vec<f64>; 3] {
        let of = |column: &Vec<f64>| -> Vector3<f64> {
            let carriers = self.tip.nodes.iter().zip(&self.tip.weights);
            self.tracker.turn
                * carriers.map(|(&node, weight)| *weight * moved(column, node)).sum::<Vector3<f64>>()
        };
        let displacements: Vec<Vector3<f64>> = projection.columns.iter().map(of).collect();
        std::array::from_fn(|c| displacements.iter().map(|displacement| displacement[c]).collect())
    }

    /// Derivative of coordinate `c` of the recorded tip by the displacement of each free unknown (n_unknowns)
    /// [-].
    pub(crate) fn tip_weights(&self, c: usize) -> Vec<f64> {
        let mut weights = vec![0.0; self.body.n_unknowns()];
        for (&node, weight) in self.tip.nodes.iter().zip(&self.tip.weights) {
            let first = 3 * node as usize;
            for (k, entry) in weights.iter_mut().skip(first).take(3).enumerate() {
                *entry += weight * self.tracker.turn[(c, k)];
            }
        }
        weights
    }

    /// Coordinates of the recorded tip's displacement, one row each, for displacements of the free unknowns, one column
    /// each (n_unknowns).
    pub(crate) fn tip_displacements(&self, columns: [&[f64]; 3]) -> [[f64; 3]; 3] {
        [0, 1, 2].map(|c| {
            let weights = self.tip_weights(c);
            columns.map(|column| weights.iter().zip(column).map(|(w, d)| w * d).sum())
        })
    }

    /// Rotation of the tip by the unit tension of each cable: three rows of the rotation vector, in space
    /// [rad/N]. The derivative of [`Self::tip_rotation_of`] for a tip that keeps its form.
    pub(crate) fn tip_rotation_rows(&self, projection: &Projection, state: &TwinState) -> [Vec<f64>; 3] {
        let arms = self.tip_arms(&state.positions);
        let square: Matrix3<f64> =
            arms.iter().map(|arm| Matrix3::identity() * arm.norm_squared() - arm * arm.transpose()).sum();
        let inverse = square.try_inverse().unwrap_or_else(Matrix3::zeros);
        let turn = |column: &Vec<f64>| -> Vector3<f64> {
            let nodes = self.tip.nodes.iter().zip(&arms);
            inverse
                * nodes
                    .map(|(&node, arm)| arm.cross(&(self.tracker.turn * moved(column, node))))
                    .sum::<Vector3<f64>>()
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
