//! Responses of a chain and its tip to tensions, strokes and forces, with the factor at hand.

use hysteron_fem::vectors::{combine_into, dot};
use nalgebra::{DMatrix, DVector};

use super::BLOCK;
use super::band::BlockVector;
use super::columns::TIP_LOADS;
use super::solver::ChainSolver;
use crate::solver::{TensionResponse, TipDerivatives, TipMotion};

impl ChainSolver {
    /// Response of cables and tip to tensions.
    pub(super) fn tension_response(&mut self, tip: TipMotion) -> TensionResponse {
        self.solve_tip(if tip == TipMotion::Pose { TIP_LOADS } else { 3 });
        TensionResponse {
            delassus: self.cables.delassus.clone(),
            tip: [0, 1, 2].map(|c| self.strokes_by(&self.tip_columns[c])),
            turn: (tip == TipMotion::Pose).then(|| [3, 4, 5].map(|c| self.strokes_by(&self.tip_columns[c]))),
        }
    }

    /// Derivatives of the tip, cables `held`, which have their columns, keeping their strokes; `None` where two of them pull
    /// the same way.
    pub(super) fn derivatives_of_tip(&mut self, held: &[usize]) -> Option<TipDerivatives> {
        self.solve_tip(3);
        let mut per_tension = [0, 1, 2].map(|c| self.strokes_by(&self.tip_columns[c]));
        let loads = [0, 1, 2].map(|c| self.tip_load(c));
        let along = |row: &[BlockVector], column: &[BlockVector]| {
            dot(self.chain.isa, row.as_flattened(), column.as_flattened())
        };
        let mut per_force = [0, 1, 2].map(|a| [0, 1, 2].map(|b| along(&loads[a], &self.tip_columns[b])));
        if held.is_empty() {
            return Some(TipDerivatives { per_tension, per_stroke: [const { Vec::new() }; 3], per_force });
        }
        let m = self.chain.cables.len();
        let among =
            DMatrix::from_fn(held.len(), held.len(), |a, b| self.cables.delassus[held[a] * m + held[b]]);
        // Symmetric, but not definite where only the strokes hold the body.
        let among = among.lu();
        let by_held: [Vec<f64>; 3] = per_tension.each_ref().map(|row| held.iter().map(|&j| row[j]).collect());
        let mut per_stroke = [const { Vec::new() }; 3];
        for c in 0..3 {
            let of_held = among.solve(&DVector::from_column_slice(&by_held[c]))?;
            for (j, per_tension) in per_tension[c].iter_mut().enumerate() {
                let coupled =
                    held.iter().zip(of_held.iter()).map(|(&h, s)| s * self.cables.delassus[h * m + j]);
                *per_tension -= coupled.sum::<f64>();
            }
            for (per_force, by_held) in per_force[c].iter_mut().zip(&by_held) {
                *per_force -= of_held.iter().zip(by_held).map(|(s, t)| s * t).sum::<f64>();
            }
            per_stroke[c] = of_held.as_slice().to_vec();
        }
        Some(TipDerivatives { per_tension, per_stroke, per_force })
    }

    /// Makes the first `n` columns of the tip be of the factor in use.
    fn solve_tip(&mut self, n: usize) {
        if self.n_tip_columns >= n {
            return;
        }
        for c in 0..n {
            self.tip_columns[c] = self.tip_load(c);
        }
        let columns: [usize; TIP_LOADS] = std::array::from_fn(|c| c);
        self.tangent.solve_many(&mut self.tip_columns, &columns[..n], &mut self.cables.panel);
        self.n_tip_columns = n;
    }

    /// A unit force on the tip along coordinate `c` of the frame in which it is recorded, or from the fourth on a moment that
    /// turns it about the axis.
    fn tip_load(&self, c: usize) -> Vec<BlockVector> {
        let Self { chain, tip, .. } = self;
        let mut load = vec![[0.0; BLOCK]; chain.n_sections()];
        for axis in 0..3 {
            let weight = chain.tracker.turn[(c % 3, axis)];
            if c < 3 {
                combine_into(chain.isa, &[weight], &[tip[axis].as_flattened()], load.as_flattened_mut());
            } else if let Some(end) = load.last_mut() {
                end[3 + axis] = weight / chain.lever;
            }
        }
        load
    }

    /// Strokes of all cables under a displacement of the body: by symmetry what their tensions do along its load.
    fn strokes_by(&self, displacement: &[BlockVector]) -> Vec<f64> {
        (0..self.chain.cables.len()).map(|j| self.cables.row_times(&self.chain, j, displacement)).collect()
    }
}
