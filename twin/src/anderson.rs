//! Anderson acceleration: makes a fixed-point iteration with a stale factor converge like one with a
//! fresh one, by minimising over the last few steps.
//!
//! # Reference
//! Walker, Ni (2011), Anderson acceleration for fixed-point iterations, SIAM J. Numer. Anal. 49, eq. 2.2.

use hysteron_fem::{Isa, axpy, dot};

/// Pairs kept.
const WINDOW: usize = 4;
/// Relative size below which a pivot of the normal equations counts as dependent.
const INDEPENDENT: f64 = 1e-10;

/// Pairs (change of the point, change of the proposed step) of the iteration. They stay valid across
/// steps, because a new command shifts the fixed point and not the map's derivative.
#[derive(Debug, Clone)]
pub(crate) struct Anderson {
    isa: Isa,
    moves: Vec<Vec<f64>>,
    changes: Vec<Vec<f64>>,
    /// changes_i · changes_j.
    gram: [[f64; WINDOW]; WINDOW],
    n_pairs: usize,
    /// Slot of the next pair.
    next: usize,
    last_step: Vec<f64>,
    last_move: Vec<f64>,
    has_last: bool,
}

impl Anderson {
    /// For points of `n` numbers.
    pub fn new(isa: Isa, n: usize) -> Self {
        Self {
            isa,
            moves: vec![vec![0.0; n]; WINDOW],
            changes: vec![vec![0.0; n]; WINDOW],
            gram: [[0.0; WINDOW]; WINDOW],
            n_pairs: 0,
            next: 0,
            last_step: vec![0.0; n],
            last_move: vec![0.0; n],
            has_last: false,
        }
    }

    /// Forgets all pairs: the map has changed.
    pub fn clear(&mut self) {
        self.n_pairs = 0;
        self.next = 0;
        self.has_last = false;
    }

    /// A new sequence of points begins; pairs stay.
    pub fn begin(&mut self) {
        self.has_last = false;
    }

    /// Replaces the proposed `step` by the accelerated one.
    pub fn accelerate(&mut self, step: &mut [f64]) {
        if self.has_last {
            self.add_pair(step);
        }
        self.last_step.copy_from_slice(step);
        if self.n_pairs > 0
            && let Some(factors) = self.best_factors(step)
        {
            for (i, factor) in factors.iter().enumerate().take(self.n_pairs) {
                axpy(self.isa, -factor, &self.changes[i], step);
                axpy(self.isa, -factor, &self.moves[i], step);
            }
        }
    }

    /// Tells which move was made after all.
    pub fn moved(&mut self, step: &[f64]) {
        self.last_move.copy_from_slice(step);
        self.has_last = true;
    }

    fn add_pair(&mut self, step: &[f64]) {
        let slot = self.next;
        self.moves[slot].copy_from_slice(&self.last_move);
        let change = &mut self.changes[slot];
        change.copy_from_slice(step);
        axpy(self.isa, -1.0, &self.last_step, change);
        self.n_pairs = (self.n_pairs + 1).min(WINDOW);
        self.next = (slot + 1) % WINDOW;
        for i in 0..self.n_pairs {
            let product = dot(self.isa, &self.changes[slot], &self.changes[i]);
            self.gram[slot][i] = product;
            self.gram[i][slot] = product;
        }
    }

    /// Least squares min |step - Σ factor_i change_i| by normal equations; `None` where dependent.
    fn best_factors(&self, step: &[f64]) -> Option<[f64; WINDOW]> {
        let n = self.n_pairs;
        let mut factors = [0.0; WINDOW];
        for i in 0..n {
            factors[i] = dot(self.isa, &self.changes[i], step);
        }
        let mut a = self.gram;
        for k in 0..n {
            if a[k][k] <= INDEPENDENT * self.gram[k][k] {
                return None;
            }
            for i in k + 1..n {
                let ratio = a[i][k] / a[k][k];
                for j in k..n {
                    a[i][j] -= ratio * a[k][j];
                }
                factors[i] -= ratio * factors[k];
            }
        }
        for k in (0..n).rev() {
            for j in k + 1..n {
                factors[k] -= a[k][j] * factors[j];
            }
            factors[k] /= a[k][k];
        }
        Some(factors)
    }
}
