//! Bound-constrained QP by a primal-dual active set that verifies its own optimality.
//!
//! # Reference
//! Hintermüller, Ito, Kunisch (2002), The primal-dual active set strategy as a semismooth Newton method;
//! Júdice, Pires (1994), A block principal pivoting algorithm for large-scale strictly monotone linear
//! complementarity problems.

use super::clarabel::{RowQp, solve_rows};
use super::{QpSolver, QpStatus};

/// Status of a variable.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Activity {
    /// Between its bounds.
    Free,
    /// At the lower one.
    AtLower,
    /// At the upper one.
    AtUpper,
}

/// min ½ xᵀW x - bᵀx subject to lo <= x <= hi, for a W that stays and a b that changes.
///
/// Keeps the factor of W over the variables between their bounds, and the last active set as the next
/// guess, so that a solve costs one small triangular solve while the active set does not change.
#[derive(Debug, Clone)]
pub struct BoxQp {
    n: usize,
    /// Dimensionless W: unit diagonal. Row-major n × n.
    w: Vec<f64>,
    /// 1 / sqrt(W_jj): variable = scale × dimensionless variable.
    scale: Vec<f64>,
    active_set: Vec<Activity>,
    /// Variables between their bounds, ascending, for which `factor` holds.
    free: Vec<usize>,
    /// Cholesky factor of W over `free`, row-major, stride n.
    factor: Vec<f64>,
    factor_is_current: bool,
    x: Vec<f64>,
    right: Vec<f64>,
    /// Bounds of the present solve, dimensionless.
    bounds: Vec<[f64; 2]>,
}

/// Relative to a unit diagonal: regularises tendons that pull the same way, so that their tension is
/// shared instead of undetermined (the R of eq. 4).
const REGULARISATION: f64 = 1e-10;
/// Violation that counts, relative to the largest dimensionless stroke error.
const TOLERANCE: f64 = 1e-9;
/// Changes of the active set, and those among them that move all offending variables at once. That takes
/// two or three changes as a rule, but can go round in circles; moving the last one alone cannot.
const MAX_CHANGES: usize = 200;
const MAX_CHANGES_OF_ALL: usize = 12;

impl BoxQp {
    /// A problem with `n` variables; set W before solving.
    pub fn new(n: usize) -> Self {
        Self {
            n,
            w: vec![0.0; n * n],
            scale: vec![1.0; n],
            active_set: vec![Activity::Free; n],
            free: Vec::with_capacity(n),
            factor: vec![0.0; n * n],
            factor_is_current: false,
            x: vec![0.0; n],
            right: vec![0.0; n],
            bounds: vec![[0.0; 2]; n],
        }
    }

    /// Replaces W (row-major n × n, symmetric positive semidefinite with a positive diagonal) [m/N].
    pub fn set_matrix(&mut self, w: &[f64]) {
        let n = self.n;
        for j in 0..n {
            self.scale[j] = 1.0 / w[j * n + j].sqrt();
        }
        for i in 0..n {
            for j in 0..n {
                self.w[i * n + j] = w[i * n + j] * self.scale[i] * self.scale[j];
            }
            self.w[i * n + i] += REGULARISATION;
        }
        self.factor_is_current = false;
    }

    /// Status of each variable after the last solve.
    pub fn active_set(&self) -> &[Activity] {
        &self.active_set
    }

    /// Solves for the stroke errors `b` [m] and bounds `lo <= x <= hi` [N]; writes the increments `x` [N].
    pub fn solve(&mut self, b: &[f64], lo: &[f64], hi: &[f64], x: &mut [f64]) -> (QpStatus, QpSolver) {
        let n = self.n;
        let mut size = 0.0f64;
        for j in 0..n {
            self.bounds[j] = [lo[j] / self.scale[j], hi[j] / self.scale[j]];
            size = size.max((b[j] * self.scale[j]).abs());
        }
        let tolerance = TOLERANCE * size.max(f64::MIN_POSITIVE);
        for j in 0..n {
            let [lo, hi] = self.bounds[j];
            // A bound that moved to infinity cannot hold a variable any more.
            if lo == hi || (self.active_set[j] == Activity::AtLower && lo.is_finite()) {
                self.activate(j, Activity::AtLower);
            } else if !(self.active_set[j] == Activity::AtUpper && hi.is_finite()) {
                self.activate(j, Activity::Free);
            }
        }
        for change in 0..MAX_CHANGES {
            if !self.solve_with_active_set(b) {
                break;
            }
            let changed = if change < MAX_CHANGES_OF_ALL {
                self.change_all(b, tolerance)
            } else {
                self.change_last(b, tolerance)
            };
            if !changed {
                for j in 0..n {
                    // To the last bit on its bound, which callers compare with.
                    x[j] = match self.active_set[j] {
                        Activity::Free => self.x[j] * self.scale[j],
                        Activity::AtLower => lo[j],
                        Activity::AtUpper => hi[j],
                    };
                }
                return (QpStatus::Solved, QpSolver::ActiveSet);
            }
        }
        self.solve_with_clarabel(b, lo, hi, x)
    }

    /// How the solution changes with b while every variable stays between its bounds or at the one where it is, for
    /// changes `b` [m] and of `x` at the bounds [N]; writes the changes of the other `x`. False without a factor.
    pub fn respond(&mut self, b: &[f64], x: &mut [f64]) -> bool {
        if !self.factor_is_current && !self.factorize() {
            return false;
        }
        for j in 0..self.n {
            self.x[j] = if self.active_set[j] == Activity::Free { 0.0 } else { x[j] / self.scale[j] };
        }
        self.solve_between(b);
        for &j in &self.free {
            x[j] = self.x[j] * self.scale[j];
        }
        true
    }

    fn activate(&mut self, j: usize, activity: Activity) {
        if self.active_set[j] != activity {
            self.active_set[j] = activity;
            self.factor_is_current = false;
        }
    }

    /// Puts bound variables on their bounds and solves for the others; false without a factor.
    fn solve_with_active_set(&mut self, b: &[f64]) -> bool {
        if !self.factor_is_current && !self.factorize() {
            return false;
        }
        let n = self.n;
        for j in 0..n {
            self.x[j] = match self.active_set[j] {
                Activity::Free => 0.0,
                Activity::AtLower => self.bounds[j][0],
                Activity::AtUpper => self.bounds[j][1],
            };
        }
        self.solve_between(b);
        true
    }

    /// Solves for the variables between their bounds, the others given and these zero.
    fn solve_between(&mut self, b: &[f64]) {
        let n = self.n;
        let m = self.free.len();
        for k in 0..m {
            let row = self.free[k] * n;
            let held: f64 = (0..n).map(|j| self.w[row + j] * self.x[j]).sum();
            self.right[k] = b[self.free[k]] * self.scale[self.free[k]] - held;
        }
        for k in 0..m {
            let known: f64 = (0..k).map(|l| self.factor[k * n + l] * self.right[l]).sum();
            self.right[k] = (self.right[k] - known) / self.factor[k * n + k];
        }
        for k in (0..m).rev() {
            let known: f64 = (k + 1..m).map(|l| self.factor[l * n + k] * self.right[l]).sum();
            self.right[k] = (self.right[k] - known) / self.factor[k * n + k];
        }
        for k in 0..m {
            self.x[self.free[k]] = self.right[k];
        }
    }

    fn factorize(&mut self) -> bool {
        let n = self.n;
        self.free.clear();
        self.free.extend((0..n).filter(|&j| self.active_set[j] == Activity::Free));
        for (k, &i) in self.free.iter().enumerate() {
            for (l, &j) in self.free[..=k].iter().enumerate() {
                let (above, row) = self.factor.split_at_mut(k * n);
                let known: f64 = if l < k {
                    (0..l).map(|p| row[p] * above[l * n + p]).sum()
                } else {
                    (0..k).map(|p| row[p] * row[p]).sum()
                };
                let rest = self.w[i * n + j] - known;
                row[l] = if l < k {
                    rest / above[l * n + l]
                } else if rest > 0.0 {
                    rest.sqrt()
                } else {
                    return false;
                };
            }
        }
        self.factor_is_current = true;
        true
    }

    /// Moves every variable that violates its condition; false when all conditions hold.
    fn change_all(&mut self, b: &[f64], tolerance: f64) -> bool {
        let mut changed = false;
        for j in 0..self.n {
            let next = self.better_activity(j, b, tolerance);
            changed |= next != self.active_set[j];
            self.activate(j, next);
        }
        changed
    }

    /// Moves the last variable that violates its condition; false when all conditions hold.
    fn change_last(&mut self, b: &[f64], tolerance: f64) -> bool {
        for j in (0..self.n).rev() {
            let next = self.better_activity(j, b, tolerance);
            if next != self.active_set[j] {
                self.activate(j, next);
                return true;
            }
        }
        false
    }

    /// Next status of variable `j`: the present one if its condition holds, that is x within its
    /// bounds, and the gradient W x - b zero between them, not negative at the lower and not positive at
    /// the upper one.
    fn better_activity(&self, j: usize, b: &[f64], tolerance: f64) -> Activity {
        let n = self.n;
        let [lo, hi] = self.bounds[j];
        let activity = self.active_set[j];
        if lo == hi {
            return activity;
        }
        if activity == Activity::Free {
            return if self.x[j] < lo - tolerance {
                Activity::AtLower
            } else if self.x[j] > hi + tolerance {
                Activity::AtUpper
            } else {
                Activity::Free
            };
        }
        let along: f64 = (0..n).map(|k| self.w[j * n + k] * self.x[k]).sum();
        let gradient = along - b[j] * self.scale[j];
        match activity {
            Activity::AtLower if gradient < -tolerance => Activity::Free,
            Activity::AtUpper if gradient > tolerance => Activity::Free,
            activity => activity,
        }
    }

    fn solve_with_clarabel(
        &mut self,
        b: &[f64],
        lo: &[f64],
        hi: &[f64],
        x: &mut [f64],
    ) -> (QpStatus, QpSolver) {
        let n = self.n;
        let qp = RowQp {
            hessian: self.w.clone(),
            linear: (0..n).map(|j| -b[j] * self.scale[j]).collect(),
            bounds: self.bounds.clone(),
            rows: Vec::new(),
            row_bounds: Vec::new(),
        };
        let (solution, status) = solve_rows(&qp);
        for j in 0..n {
            x[j] = (solution[j] * self.scale[j]).clamp(lo[j], hi[j]);
            let [lo, hi] = self.bounds[j];
            let close = TOLERANCE.sqrt() * (1.0 + solution[j].abs());
            let activity = if solution[j] - lo < close {
                Activity::AtLower
            } else if hi - solution[j] < close {
                Activity::AtUpper
            } else {
                Activity::Free
            };
            self.activate(j, activity);
        }
        (status, QpSolver::Clarabel)
    }
}

#[cfg(test)]
mod tests {
    use rand::RngExt;

    use super::*;

    #[test]
    fn clarabel_stands_in_for_the_active_set() {
        let mut rng = hysteron_base::rng(1, "stand-in");
        for _ in 0..200 {
            let a: [[f64; 3]; 3] =
                std::array::from_fn(|_| std::array::from_fn(|_| rng.random_range(-1.0..1.0)));
            let product = |i: usize, j: usize| (0..3).map(|k| a[i][k] * a[j][k]).sum::<f64>();
            let unit = |i: usize, j: usize| f64::from(u8::from(i == j));
            let w: Vec<f64> =
                (0..9).map(|k| 1e-4 * (product(k / 3, k % 3) + 0.1 * unit(k / 3, k % 3))).collect();
            let b: [f64; 3] = std::array::from_fn(|_| rng.random_range(-2e-3..2e-3));
            let (lo, hi) = ([0.0, -5.0, 2.0], [f64::INFINITY, 5.0, 2.0]);
            let mut qp = BoxQp::new(3);
            qp.set_matrix(&w);
            let (mut x, mut y) = ([0.0; 3], [0.0; 3]);
            assert_eq!(qp.solve(&b, &lo, &hi, &mut x), (QpStatus::Solved, QpSolver::ActiveSet));
            assert_eq!(qp.solve_with_clarabel(&b, &lo, &hi, &mut y), (QpStatus::Solved, QpSolver::Clarabel));
            for j in 0..3 {
                // Clarabel stops at a gap of 1e-11 of the cost: its root in x, of up to 50 N.
                assert!((x[j] - y[j]).abs() < 1e-4, "{x:?} and {y:?}");
                assert!((lo[j]..=hi[j]).contains(&y[j]));
            }
            // The active set that it leaves behind is the right one: nothing has to change.
            let mut z = [0.0; 3];
            assert_eq!(qp.solve(&b, &lo, &hi, &mut z).1, QpSolver::ActiveSet);
            for j in 0..3 {
                assert!((x[j] - z[j]).abs() < 1e-9, "{x:?} and {z:?}");
            }
        }
    }
}
