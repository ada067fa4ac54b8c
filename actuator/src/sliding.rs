//! Slips of a tendon whose friction gives way before it slides: a semismooth Newton method.
//!
//! With z_j(u_j) the share of the friction bound of guide j, all its slips solve
//!
//!   f_j = (1 - h_j z_j) T_{j-1} - (1 + h_j z_j) T_j - F z_j = 0,     h_j = tanh(μθ_j/2).
//!
//! Every f_j falls with its own slip and rises with its neighbours', so the solution is unique; the system of each iteration
//! is tridiagonal and diagonally dominant. A slip stops where it would reverse: there the slope of z jumps.

use crate::tendon::{Guide, ROUNDING, TendonModel, TendonTrial};

/// More iterations than any increment has needed by far.
const MAX_ITERATIONS: usize = 200;
const MAX_HALVINGS: usize = 30;
/// Sweeps over the guides where Newton's direction leads nowhere, and halvings of each slip's interval.
const SWEEPS: usize = 10;
const BISECTIONS: usize = 60;
/// Slope of z at which a guide still counts as giving way, over 1/δ: between slack segments nothing else holds its slip.
const TRACE: f64 = 1e-6;
/// Residual over E A that rounding leaves [-].
const ROOM: f64 = 10.0 * ROUNDING;

impl TendonModel {
    /// Finds slips and tensions, from the slips in `trial`; its row factors are then those of the tangent.
    pub(crate) fn solve_sliding(&self, lengths: &[f64], trial: &mut TendonTrial) {
        let m = self.n_segments();
        let room = ROOM * self.spec.axial_stiffness;
        if !trial.slips.iter().all(|slip| slip.is_finite()) {
            // Of lengths that were none.
            trial.slips[1..].copy_from_slice(&self.slips[1..]);
        }
        let mut miss = self.evaluate_sliding(lengths, trial);
        for _ in 0..MAX_ITERATIONS {
            if miss <= room {
                break;
            }
            // The change of each slip, in `right`.
            for j in (1..m).rev() {
                let after = if j + 1 < m { trial.right[j + 1] } else { 0.0 };
                trial.right[j] += trial.upper[j] * after;
            }
            trial.start.copy_from_slice(&trial.slips);
            trial.change.copy_from_slice(&trial.right);
            let (mut part, mut next) = (1.0, f64::INFINITY);
            for _ in 0..MAX_HALVINGS {
                for j in 1..m {
                    let from = trial.start[j] - self.slips[j];
                    let to = from + part * trial.change[j];
                    let reverses = from != 0.0 && to * from < 0.0;
                    trial.slips[j] = if reverses { self.slips[j] } else { self.slips[j] + to };
                }
                next = self.evaluate_sliding(lengths, trial);
                if next < miss {
                    break;
                }
                part *= 0.5;
            }
            if next >= miss {
                // Where several slips stop at once, Newton's direction may lead nowhere: one guide after the other does.
                trial.slips.copy_from_slice(&trial.start);
                for _ in 0..SWEEPS {
                    (1..m).for_each(|j| self.relax(lengths, trial, j));
                }
                next = self.evaluate_sliding(lengths, trial);
            }
            miss = next;
        }
        trial.has_cycled = miss > room;
        for j in 1..m {
            let slip = trial.slips[j] - self.slips[j];
            trial.guides[j] = match slip {
                slip if slip > 0.0 => Guide::Pulls,
                slip if slip < 0.0 => Guide::Releases,
                _ => Guide::Sticks,
            };
        }
    }

    /// Sets slip j to where its own f_j is zero while the others stay, by bisection: f_j falls with it. For such equations sweeps over
    /// the guides converge from anywhere (Rheinboldt 1970, On M-functions and their application to nonlinear Gauss-Seidel iterations).
    fn relax(&self, lengths: &[f64], trial: &mut TendonTrial, j: usize) {
        let law = self.spec.law;
        let miss = |slip: f64, slips: &[f64]| {
            let stretch = |i: usize, own: f64| self.stretch(lengths, slips, i) + own;
            let own = slip - slips[j];
            let before = self.stiffness[j - 1] * stretch(j - 1, -own).max(0.0);
            let after = self.stiffness[j] * stretch(j, own).max(0.0);
            let [z, _] = law.engaged(&self.elements[j], slip - self.slips[j], 1.0);
            before - after - (self.spec.friction_force + trial.factors[j] * (before + after)) * z
        };
        let (mut low, mut high, mut reach) = (trial.slips[j], trial.slips[j], law.presliding());
        while miss(low, &trial.slips) < 0.0 && reach < self.spec.rest_lengths[0] {
            (high, low, reach) = (low, low - reach, 2.0 * reach);
        }
        while miss(high, &trial.slips) > 0.0 && reach < self.spec.rest_lengths[0] {
            (low, high, reach) = (high, high + reach, 2.0 * reach);
        }
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (low + high);
            if miss(middle, &trial.slips) > 0.0 {
                low = middle;
            } else {
                high = middle;
            }
        }
        trial.slips[j] = 0.5 * (low + high);
    }

    /// Tensions and row factors at the trial slips, and the right-hand side of Newton's system, its lower part eliminated, in
    /// `right`; the sum of |f_j| [N].
    fn evaluate_sliding(&self, lengths: &[f64], trial: &mut TendonTrial) -> f64 {
        let m = self.n_segments();
        for i in 0..m {
            let stretch = self.stretch(lengths, &trial.slips, i);
            trial.is_taut[i] = stretch > 0.0;
            trial.tensions[i] = self.stiffness[i] * stretch.max(0.0);
        }
        let k = |i: usize, is_taut: &[bool]| if is_taut[i] { self.stiffness[i] } else { 0.0 };
        let mut sum = 0.0;
        for j in 1..m {
            let (before, after, h) = (trial.tensions[j - 1], trial.tensions[j], trial.factors[j]);
            let bound = self.spec.friction_force + h * (before + after);
            let slip = trial.slips[j] - self.slips[j];
            let law = self.spec.law;
            let [z, _] = law.engaged(&self.elements[j], slip, 1.0);
            let f = before - after - bound * z;
            let [_, slope] = law.engaged(&self.elements[j], slip, f);
            let gives = bound * slope.max(TRACE / law.presliding());
            let (left, right) =
                ((1.0 - h * z) * k(j - 1, &trial.is_taut), (1.0 + h * z) * k(j, &trial.is_taut));
            // left + right + gives - left upper_{j-1}, without its cancellation.
            let pivot = right + gives + left * trial.defect[j - 1];
            trial.row[j] = [left, right];
            trial.defect[j] = (gives + left * trial.defect[j - 1]) / pivot;
            trial.pivot[j] = pivot;
            trial.upper[j] = right / pivot;
            let previous = if j == 1 { 0.0 } else { trial.right[j - 1] };
            trial.right[j] = (f + left * previous) / pivot;
            sum += f.abs();
        }
        sum
    }
}
