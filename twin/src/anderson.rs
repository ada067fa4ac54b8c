//! Anderson acceleration: makes a fixed-point iteration with a lagged factor converge like one with a fresh
//! one, by minimising over the last few steps.
//!
//! # Reference
//! Walker, Ni (2011), Anderson acceleration for fixed-point iterations, SIAM J. Numer. Anal. 49, eq. 2.2.

use hysteron_base::lanes::Isa;
use hysteron_fem::vectors::{combine_into, dot};

/// Pairs kept.
const WINDOW: usize = 6;
/// Relative size below which a pivot of the normal equations counts as dependent.
const INDEPENDENT: f64 = 1e-10;

/// A move of the point, and the changes that it caused in all inputs of a step. Strokes, tensions and forces
/// are smooth: where a cable goes slack or a friction point begins to slip, the same pair gives another
/// change of the step.
#[derive(Debug, Clone)]
pub(crate) struct AndersonPair {
    /// The move: free unknowns, then tensions times their mean compliance [m].
    pub moved: Vec<f64>,
    /// Change of K⁻¹ r [m].
    pub free_displacement: Vec<f64>,
    /// Change of the stroke residual of each cable when only the free displacement is made [m].
    pub stroke_residual: Vec<f64>,
    /// Change of the proposed step, with each cable between its bounds or at one as it is now.
    pub change: Vec<f64>,
}

/// Pairs of the iteration's last moves. They stay valid across steps, because a new command shifts the fixed point and
/// not the map's derivative.
#[derive(Debug, Clone)]
pub(crate) struct Anderson {
    isa: Isa,
    pairs: Vec<AndersonPair>,
    /// change_i · change_j.
    gram: [[f64; WINDOW]; WINDOW],
    n_pairs: usize,
    /// Slot of the next pair.
    next: usize,
    /// The last move, and free displacement, missing strokes and proposed step from before it.
    last: AndersonPair,
    has_last: bool,
}

impl Anderson {
    /// For `n` free unknowns and `m` cables.
    pub fn new(isa: Isa, n: usize, m: usize) -> Self {
        let blank = AndersonPair {
            moved: vec![0.0; n + m],
            free_displacement: vec![0.0; n],
            stroke_residual: vec![0.0; m],
            change: vec![0.0; n + m],
        };
        Self {
            isa,
            pairs: vec![blank.clone(); WINDOW],
            gram: [[0.0; WINDOW]; WINDOW],
            n_pairs: 0,
            next: 0,
            last: blank,
            has_last: false,
        }
    }

    /// Drops all pairs: the map has changed.
    pub fn clear(&mut self) {
        self.n_pairs = 0;
        self.next = 0;
        self.has_last = false;
    }

    /// A new sequence of points begins; pairs stay.
    pub fn begin(&mut self) {
        self.has_last = false;
    }

    /// Learns from what the last move led to: the proposed `step`, and the `free displacement` and `missing` that it was made from.
    pub fn observe(&mut self, step: &[f64], free_displacement: &[f64], stroke_residual: &[f64]) {
        let last = &mut self.last;
        if self.has_last {
            let pair = &mut self.pairs[self.next];
            std::mem::swap(&mut pair.moved, &mut last.moved);
            replace(&mut last.change, step, &mut pair.change);
            replace(&mut last.free_displacement, free_displacement, &mut pair.free_displacement);
            replace(&mut last.stroke_residual, stroke_residual, &mut pair.stroke_residual);
            self.n_pairs = (self.n_pairs + 1).min(WINDOW);
            self.multiply(self.next, self.n_pairs);
            self.next = (self.next + 1) % WINDOW;
        } else {
            last.change.copy_from_slice(step);
            last.free_displacement.copy_from_slice(free_displacement);
            last.stroke_residual.copy_from_slice(stroke_residual);
        }
    }

    /// After a change of the active set: `change_of` rewrites the changes of the step.
    pub fn revise(&mut self, change_of: impl FnMut(&mut AndersonPair)) {
        self.pairs[..self.n_pairs].iter_mut().for_each(change_of);
        (0..self.n_pairs).for_each(|slot| self.multiply(slot, slot + 1));
    }

    #[cfg(test)]
    pub fn changes(&self) -> Vec<Vec<f64>> {
        self.pairs[..self.n_pairs].iter().map(|pair| pair.change.clone()).collect()
    }

    /// The products of one change with the first `count`.
    fn multiply(&mut self, slot: usize, count: usize) {
        for i in 0..count {
            let product = dot(self.isa, &self.pairs[slot].change, &self.pairs[i].change);
            self.gram[slot][i] = product;
            self.gram[i][slot] = product;
        }
    }

    /// Replaces the proposed `step` by the accelerated one.
    pub fn accelerate(&mut self, step: &mut [f64]) {
        if self.n_pairs > 0
            && let Some(factors) = self.best_factors(step)
        {
            let factors = factors.map(|factor| -factor);
            let of = |part: fn(&AndersonPair) -> &[f64]| {
                std::array::from_fn::<_, WINDOW, _>(|i| part(&self.pairs[i]))
            };
            combine_into(self.isa, &factors, &of(|pair| &pair.change), step);
            combine_into(self.isa, &factors, &of(|pair| &pair.moved), step);
        }
    }

    /// Records the move that was made.
    pub fn moved(&mut self, step: &[f64]) {
        self.last.moved.copy_from_slice(step);
        self.has_last = true;
    }

    /// Least squares min |step - Σ factor_i change_i| by normal equations; `None` where dependent.
    fn best_factors(&self, step: &[f64]) -> Option<[f64; WINDOW]> {
        let n = self.n_pairs;
        let mut factors = [0.0; WINDOW];
        for i in 0..n {
            factors[i] = dot(self.isa, &self.pairs[i].change, step);
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

/// Puts `new` in the place of `old`; `change` becomes their difference.
fn replace(old: &mut [f64], new: &[f64], change: &mut [f64]) {
    for ((old, new), change) in old.iter_mut().zip(new).zip(change) {
        *change = new - *old;
        *old = *new;
    }
}
