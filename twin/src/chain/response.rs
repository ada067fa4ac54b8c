//! Responses of a chain and its tip to tensions, strokes and forces, with the factor at hand.

use hysteron_fem::vectors::{combine_into, dot};
use nalgebra::{DMatrix, DVector, Vector3};

use super::BLOCK;
use super::band::BlockVector;
use super::solver::ChainSolver;
use crate::solver::{TensionResponse, TipDerivatives, TipMotion};

impl ChainSolver {
    /// Response of cables and tip to tensions.
    pub(super) fn tension_response(&self, tip: TipMotion) -> TensionResponse {
        let turn = |column: &Vec<BlockVector>| -> Vector3<f64> {
            let end = column.last().map_or([0.0; BLOCK], |end| *end);
            self.chain.tracker.turn * Vector3::new(end[3], end[4], end[5]) / self.chain.lever
        };
        TensionResponse {
            delassus: self.delassus.clone(),
            tip: self.tip_moves(self.columns.iter()),
            turn: (tip == TipMotion::Pose).then(|| rows_of(self.columns.iter().map(turn))),
        }
    }

    /// Derivatives of the tip, cables `held` keeping their strokes; `None` where two of them pull the same way.
    pub(super) fn derivatives_of_tip(&mut self, held: &[usize]) -> Option<TipDerivatives> {
        let mut loads = [0, 1, 2].map(|c| self.tip_force(c));
        self.tangent.solve_many(&mut loads, &mut self.panel);
        let mut per_tension = self.tip_moves(self.columns.iter());
        let mut per_force = self.tip_moves(loads.iter()).map(|row| [row[0], row[1], row[2]]);
        if held.is_empty() {
            return Some(TipDerivatives { per_tension, per_stroke: [const { Vec::new() }; 3], per_force });
        }
        let m = self.rows.len();
        let among = DMatrix::from_fn(held.len(), held.len(), |a, b| self.delassus[held[a] * m + held[b]]);
        // Symmetric, but not definite where only the strokes hold the body.
        let among = among.lu();
        let by_held: [Vec<f64>; 3] = per_tension.each_ref().map(|row| held.iter().map(|&j| row[j]).collect());
        let mut per_stroke = [const { Vec::new() }; 3];
        for c in 0..3 {
            let of_held = among.solve(&DVector::from_column_slice(&by_held[c]))?;
            for (j, per_tension) in per_tension[c].iter_mut().enumerate() {
                let coupled = held.iter().zip(of_held.iter()).map(|(&h, s)| s * self.delassus[h * m + j]);
                *per_tension -= coupled.sum::<f64>();
            }
            for (per_force, by_held) in per_force[c].iter_mut().zip(&by_held) {
                *per_force -= of_held.iter().zip(by_held).map(|(s, t)| s * t).sum::<f64>();
            }
            per_stroke[c] = of_held.as_slice().to_vec();
        }
        Some(TipDerivatives { per_tension, per_stroke, per_force })
    }

    /// A unit force on the tip along coordinate `c` of the frame in which it is recorded.
    fn tip_force(&self, c: usize) -> Vec<BlockVector> {
        let Self { chain, tip, .. } = self;
        let mut load = vec![[0.0; BLOCK]; chain.n_sections()];
        for (axis, row) in tip.iter().enumerate() {
            let weight = chain.tracker.turn[(c, axis)];
            combine_into(chain.isa, &[weight], &[row.as_flattened()], load.as_flattened_mut());
        }
        load
    }

    /// Coordinates of the recorded tip's displacement under each of `columns`: three rows.
    fn tip_moves<'a>(&self, columns: impl Iterator<Item = &'a Vec<BlockVector>>) -> [Vec<f64>; 3] {
        let chain = &self.chain;
        let moved = |column: &Vec<BlockVector>| -> Vector3<f64> {
            let along = |c: usize| dot(chain.isa, self.tip[c].as_flattened(), column.as_flattened());
            chain.tracker.turn * Vector3::from_fn(|c, _| along(c))
        };
        rows_of(columns.map(moved))
    }
}

/// Three rows of as many columns.
fn rows_of(columns: impl Iterator<Item = Vector3<f64>>) -> [Vec<f64>; 3] {
    let mut rows = [const { Vec::new() }; 3];
    for column in columns {
        rows.iter_mut().zip(column.iter()).for_each(|(row, value)| row.push(*value));
    }
    rows
}
