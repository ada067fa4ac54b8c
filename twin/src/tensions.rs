//! The tension increments of a correction: the bound-constrained QP of eq. 4, posed and applied.

use crate::equilibrium_residual::StepTargets;
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
