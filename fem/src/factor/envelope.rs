//! The single-precision block envelope as a stiffness factor.

use super::HINT;
use crate::simd::{BLOCK, BlockEnvelope, Isa, SolutionPanel};
use crate::stiffness::{Stiffness, StiffnessPattern};
use crate::{Error, Result};

/// Right-hand sides from which a panel of sixteen is faster than one solve each.
const PANEL_FROM: usize = 5;

#[derive(Debug, Clone)]
pub(super) struct EnvelopeFactor {
    isa: Isa,
    n: usize,
    envelope: BlockEnvelope,
    /// Place in the envelope of each scalar of the pattern's blocks; both halves of a diagonal block go
    /// to the lower one.
    positions: Vec<[u32; 9]>,
    /// One padded right-hand side.
    single: Vec<f32>,
    panel: SolutionPanel,
}

impl EnvelopeFactor {
    pub fn new(pattern: &StiffnessPattern, isa: Isa) -> Self {
        let n = 3 * pattern.n_free();
        let envelope = BlockEnvelope::new(&pattern.first_columns());
        let mut positions = vec![[0; 9]; pattern.n_blocks()];
        for (row, column, index) in pattern.scalar_entries() {
            let (slot, i, j) = (index / 12, row % 3, column % 3);
            let position = envelope.position(row, column) as u32;
            positions[slot][3 * i + j] = position;
            if row / 3 == column / 3 {
                positions[slot][3 * j + i] = position;
            }
        }
        let single = vec![0.0; envelope.n_padded()];
        let panel = SolutionPanel::zeros(envelope.n_padded());
        Self { isa, n, envelope, positions, single, panel }
    }

    /// Mean number of stored entries a row.
    pub fn mean_row(pattern: &StiffnessPattern) -> f64 {
        let first = pattern.first_columns();
        let stored: usize = first.iter().enumerate().map(|(row, column)| row + 1 - column).sum();
        stored as f64 / first.len() as f64
    }

    pub fn n_stored(&self) -> usize {
        self.envelope.n_stored()
    }

    pub fn factorize(&mut self, stiffness: &Stiffness) -> Result<()> {
        self.envelope.load(self.n, &self.positions, &stiffness.blocks);
        self.envelope.factorize(self.isa).map_err(|unknown| Error::NotPositiveDefinite {
            unknown,
            n_unknowns: self.n,
            hint: HINT,
        })
    }

    pub fn solve(&mut self, x: &mut [f64]) {
        for (single, x) in self.single.iter_mut().zip(x.iter()) {
            *single = *x as f32;
        }
        self.single[self.n..].fill(0.0);
        self.envelope.solve(self.isa, &mut self.single);
        for (x, single) in x.iter_mut().zip(&self.single) {
            *x = f64::from(*single);
        }
    }

    pub fn solve_many(&mut self, columns: &mut [Vec<f64>]) {
        for chunk in columns.chunks_mut(BLOCK) {
            if chunk.len() < PANEL_FROM {
                chunk.iter_mut().for_each(|column| self.solve(column));
                continue;
            }
            self.panel.load(chunk);
            self.envelope.solve_panel(self.isa, &mut self.panel);
            self.panel.store(chunk);
        }
    }
}
