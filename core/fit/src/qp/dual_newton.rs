//! A regularised least-squares problem of few rows in boxes, by Newton's method on its dual.
//!
//! With the multiplier η = e - G x every variable is alone: x(η) = (Gᵀη)/γ - s, put back into its box. So the dual is a
//! smooth convex, piecewise quadratic function of as many numbers as there are rows,
//!
//! ```text
//! φ(η) = ½ |η|² - eᵀη + Σ max { x_k (Gᵀη)_k - γ/2 (x_k + s_k)² : x_k in its box },   ∇φ = η - e + G x(η),
//! ```
//!
//! and Newton's method with exact line searches finds its minimum. However many bounds hold, that takes a few steps.
//!
//! # Reference
//! Li, Swetits (1997), A new algorithm for solving strictly convex quadratic programs, SIAM J. Optim. 7.

use nalgebra::{DMatrix, DVector};

use super::QpStatus;
use super::clarabel::{RowQp, solve_rows};

/// Newton steps: a handful as a rule, and never many.
const MAX_STEPS: usize = 100;
/// |∇φ| that an answer may have, relative to its terms: round-off, and room for it.
const TOLERANCE: f64 = 1e-12;

/// min ½ |e - G x|² + γ/2 |x + s|² subject to bounds on x; everything dimensionless, of order one.
#[derive(Debug, Clone)]
pub struct BoxedRows {
    /// G (rows × n).
    pub gain: DMatrix<f64>,
    /// e (rows).
    pub error: DVector<f64>,
    /// γ > 0.
    pub gamma: f64,
    /// s (n).
    pub before: DVector<f64>,
    /// Lower and upper bound of each variable.
    pub bounds: Vec<[f64; 2]>,
}

/// A point of the dual.
struct DualPoint {
    multiplier: DVector<f64>,
    /// Gᵀη.
    pull: DVector<f64>,
    x: DVector<f64>,
    gradient: DVector<f64>,
}

impl BoxedRows {
    /// Solves the dual, or where its answer cannot be certified, asks clarabel.
    pub fn solve(&self) -> (DVector<f64>, QpStatus) {
        if let Some(x) = self.solve_dual() {
            return (x, QpStatus::Solved);
        }
        let (x, status) = solve_rows(&self.to_row_qp());
        (DVector::from_vec(x), status)
    }

    /// The same problem written out.
    pub fn to_row_qp(&self) -> RowQp {
        let n = self.before.len();
        let hessian = self.gain.tr_mul(&self.gain) + self.gamma * DMatrix::identity(n, n);
        let linear = self.gamma * &self.before - self.gain.tr_mul(&self.error);
        RowQp {
            hessian: hessian.as_slice().to_vec(),
            linear: linear.as_slice().to_vec(),
            bounds: self.bounds.clone(),
            rows: Vec::new(),
            row_bounds: Vec::new(),
        }
    }

    /// `None` where no answer can be certified.
    fn solve_dual(&self) -> Option<DVector<f64>> {
        let mut at = self.at(DVector::zeros(self.error.len()));
        for _ in 0..MAX_STEPS {
            if at.gradient.norm() <= TOLERANCE * (at.multiplier.norm() + self.error.norm()) {
                return Some(at.x);
            }
            let step = self.newton_step(&at)?;
            let part = self.best_step_length(&at, &step);
            at = self.at(&at.multiplier - part * step);
        }
        None
    }

    /// x_k where (Gᵀη)_k is `pull`, before it is put back into its box.
    fn unbounded(&self, k: usize, pull: f64) -> f64 {
        pull / self.gamma - self.before[k]
    }

    fn bounded(&self, k: usize, pull: f64) -> f64 {
        let [lowest, highest] = self.bounds[k];
        self.unbounded(k, pull).max(lowest).min(highest)
    }

    fn at(&self, multiplier: DVector<f64>) -> DualPoint {
        let pull = self.gain.tr_mul(&multiplier);
        let x = DVector::from_fn(pull.len(), |k, _| self.bounded(k, pull[k]));
        let gradient = &multiplier - &self.error + &self.gain * &x;
        DualPoint { multiplier, pull, x, gradient }
    }

    /// (1 + G_between G_betweenᵀ / γ)⁻¹ ∇φ.
    fn newton_step(&self, at: &DualPoint) -> Option<DVector<f64>> {
        let rows = self.error.len();
        let mut curvature = DMatrix::identity(rows, rows);
        for (k, column) in self.gain.column_iter().enumerate() {
            let [lowest, highest] = self.bounds[k];
            if lowest < at.x[k] && at.x[k] < highest {
                curvature.ger(1.0 / self.gamma, &column, &column, 1.0);
            }
        }
        Some(curvature.cholesky()?.solve(&at.gradient))
    }

    /// The t that minimises φ(η - t step): its derivative is linear between the breakpoints, at which a variable meets a bound.
    fn best_step_length(&self, at: &DualPoint, step: &DVector<f64>) -> f64 {
        let along = self.gain.tr_mul(step);
        let (start, square) = (step.dot(&at.multiplier) - step.dot(&self.error), step.norm_squared());
        let slope = |t: f64| {
            let of = |k: usize| along[k] * self.bounded(k, at.pull[k] - t * along[k]);
            t * square - start - (0..along.len()).map(of).sum::<f64>()
        };
        let mut breakpoints = vec![0.0];
        for k in 0..along.len() {
            let meets = |bound: f64| (self.unbounded(k, at.pull[k]) - bound) * self.gamma / along[k];
            breakpoints.extend(self.bounds[k].map(meets).into_iter().filter(|t| t.is_finite() && *t > 0.0));
        }
        breakpoints.sort_by(f64::total_cmp);
        let after = breakpoints.partition_point(|t| slope(*t) < 0.0);
        let from = breakpoints[after.max(1) - 1];
        let rise = match breakpoints.get(after.max(1)) {
            Some(&to) if to > from => (slope(to) - slope(from)) / (to - from),
            // Beyond the last breakpoint all variables are at bounds.
            _ => square,
        };
        from - slope(from) / rise
    }
}

#[cfg(test)]
mod tests {
    use rand::RngExt;

    use super::*;

    #[test]
    fn answers_meet_the_optimality_conditions_and_are_those_of_clarabel() {
        let mut rng = hysteron_base::rng(1, "boxed rows");
        let mut n_at_bounds = 0;
        for round in 0..300 {
            let (rows, n) = (3 + 3 * (round % 2), 36);
            let gamma = 0.1f64.powi(round as i32 % 7);
            let qp = BoxedRows {
                gain: DMatrix::from_fn(rows, n, |_, _| rng.random_range(-1.0..1.0)),
                error: DVector::from_fn(rows, |_, _| rng.random_range(-1.0..1.0)),
                gamma,
                before: DVector::from_fn(n, |_, _| rng.random_range(-0.1..0.1)),
                bounds: (0..n).map(|k| [-0.1, 0.02 + 0.01 * k as f64]).collect(),
            };
            let x = qp.solve_dual().expect("an answer without clarabel");
            assert_eq!(qp.solve(), (x.clone(), QpStatus::Solved));
            let gradient = qp.gain.tr_mul(&(&qp.gain * &x - &qp.error)) + gamma * (&x + &qp.before);
            // The gradient in x is Gᵀ times that of the dual, relative to terms of order one.
            const TOL: f64 = 1e-8;
            for k in 0..n {
                let [lowest, highest] = qp.bounds[k];
                assert!((lowest..=highest).contains(&x[k]));
                n_at_bounds += usize::from(x[k] == lowest || x[k] == highest);
                if x[k] > lowest {
                    assert!(gradient[k] < TOL, "round {round}: {}", gradient[k]);
                }
                if x[k] < highest {
                    assert!(gradient[k] > -TOL, "round {round}: {}", gradient[k]);
                }
            }
            let cost = |x: &DVector<f64>| {
                0.5 * (&qp.error - &qp.gain * x).norm_squared()
                    + 0.5 * gamma * (x + &qp.before).norm_squared()
            };
            let (other, status) = solve_rows(&qp.to_row_qp());
            assert_eq!(status, QpStatus::Solved);
            // Clarabel's gap is 1e-11 of a cost of order ten.
            assert!(cost(&x) <= cost(&DVector::from_vec(other)) + 1e-9);
        }
        assert!(n_at_bounds > 1000, "{n_at_bounds}");
    }
}
