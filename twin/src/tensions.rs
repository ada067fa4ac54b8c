//! The tension increments of a correction: the bound-constrained QP of eq. 4, posed and applied.

use nalgebra::{DMatrix, DVector};

use crate::equilibrium_residual::StepTargets;
use crate::error::Cause;
use hysteron_fit::qp::{BoxQp, QpSolver, QpStatus};

/// A QP in the tension increments and its answer; scratch.
#[derive(Debug, Clone)]
pub(crate) struct TensionStep {
    pub qp: BoxQp,
    /// Stroke that each cable still has to make [m].
    pub stroke_residual: Vec<f64>,
    /// Bounds of the increments [N].
    pub lower: Vec<f64>,
    pub upper: Vec<f64>,
    /// The answer [N].
    pub increments: Vec<f64>,
}

impl TensionStep {
    /// For `m` cables.
    pub fn new(m: usize) -> Self {
        let zeros = vec![0.0; m];
        Self {
            qp: BoxQp::new(m),
            stroke_residual: zeros.clone(),
            lower: zeros.clone(),
            upper: zeros.clone(),
            increments: zeros,
        }
    }

    /// Sets the data: tensions now, and the stroke residual of each cable when only the free displacement is
    /// made.
    pub fn pose(&mut self, control: &StepTargets, tensions: &[f64], stroke_residual: impl Fn(usize) -> f64) {
        for (j, tension) in tensions.iter().enumerate() {
            self.stroke_residual[j] = if control.is_tension(j) { 0.0 } else { stroke_residual(j) };
            self.lower[j] = control.lower[j] - tension;
            self.upper[j] = control.upper[j] - tension;
        }
    }

    /// Solves the QP that was posed; returns the solver that succeeded, or the status.
    pub fn solve(&mut self) -> Result<QpSolver, QpStatus> {
        let (status, solver) =
            self.qp.solve(&self.stroke_residual, &self.lower, &self.upper, &mut self.increments);
        if status == QpStatus::Solved { Ok(solver) } else { Err(status) }
    }

    /// Tension increments with an indefinite W, for the tendons that stay within their bounds: starts
    /// with all, and leaves each that would go beyond a bound on it. Fails where W is not that of a stable
    /// equilibrium under the strokes of those tendons: where it has not as many negative eigenvalues as the stiffness,
    /// `n_negative`.
    pub fn solve_taut(&mut self, delassus: &[f64], n_negative: usize) -> Result<(), Cause> {
        let Self { stroke_residual, lower, upper, increments, .. } = self;
        let n = stroke_residual.len();
        let mut taut: Vec<usize> = (0..n).filter(|&j| lower[j] < upper[j]).collect();
        increments.copy_from_slice(lower);
        while !taut.is_empty() {
            let w = |i: usize, j: usize| delassus[i * n + j];
            let matrix = DMatrix::from_fn(taut.len(), taut.len(), |k, l| w(taut[k], taut[l]));
            let right = DVector::from_fn(taut.len(), |k, _| {
                let i = taut[k];
                let held = (0..n).filter(|j| !taut.contains(j)).map(|j| w(i, j) * increments[j]);
                stroke_residual[i] - held.sum::<f64>()
            });
            let solution = matrix.clone().lu().solve(&right).ok_or(Cause::NoFactor)?;
            for (k, &j) in taut.iter().enumerate() {
                increments[j] = solution[k].clamp(lower[j], upper[j]);
            }
            let beyond = |k: usize| (solution[k] - increments[taut[k]]).abs();
            let worst = (0..taut.len()).max_by(|&a, &b| beyond(a).total_cmp(&beyond(b)));
            match worst.filter(|&k| beyond(k) > 0.0) {
                Some(k) => taut.remove(k),
                None => {
                    let negative =
                        matrix.symmetric_eigenvalues().iter().filter(|value| **value < 0.0).count();
                    return if negative == n_negative { Ok(()) } else { Err(Cause::Unstable) };
                }
            };
        }
        Err(Cause::Unstable)
    }

    /// `tensions` after `part` of `increments`; a full increment to a bound lands on it exactly, so that
    /// slackness is free of round-off.
    pub fn apply(control: &StepTargets, increments: &[f64], part: f64, tensions: &mut [f64]) {
        for (j, tension) in tensions.iter_mut().enumerate() {
            let (lower, upper) = (control.lower[j], control.upper[j]);
            *tension = if part == 1.0 && increments[j] == lower - *tension {
                lower
            } else if part == 1.0 && increments[j] == upper - *tension {
                upper
            } else {
                (*tension + part * increments[j]).clamp(lower, upper)
            };
        }
    }
}
