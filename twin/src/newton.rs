//! The robust case of a step: exact tangent, line search, sub-steps.
//!
//! The tangent includes the geometric stiffness of body and cables, factorised in double precision. Full
//! steps are tried first, as long as the exact tangent stays positive definite: a slender body that turns is
//! stretched by every Newton step, which the next one undoes, but no test on the way allows. Then, from the
//! start, a trial is accepted by the natural monotonicity test: the correction that the present factor would
//! make at the trial point must be smaller than the present one.
//!
//! # Reference
//! Deuflhard (2011), Newton methods for nonlinear problems, sec. 3.1.

use std::sync::Arc;

use hysteron_fem::{FactorKind, Stiffness, StiffnessFactor, Tangent};

use crate::balance::{Balance, Control, move_nodes};
use crate::model::Twin;
use crate::projection::Projection;
use crate::qp::{BoxQp, QpSolver, QpStatus};
use crate::step::{StepReport, TwinState};

const MAX_ITERATIONS: usize = 30;
/// Full steps that are tried first.
const MAX_FULL_STEPS: usize = 30;
/// Residual over the applied forces from which full steps are given up.
const DIVERGED: f64 = 1e8;
/// Shortest part of a Newton step that is tried.
const SHORTEST: f64 = 1.0 / 64.0;
/// Longest displacement of one Newton step, relative to the body's extent.
const LONGEST_MOVE: f64 = 0.25;

/// Exact tangent, its factor and projection; scratch.
#[derive(Debug, Clone)]
pub(crate) struct Newton {
    stiffness: Stiffness,
    factor: StiffnessFactor,
    pub projection: Projection,
    qp: BoxQp,
    trial: TwinState,
    /// K⁻¹ r.
    drift: Vec<f64>,
    displacement: Vec<f64>,
    correction: Vec<f64>,
    right: Vec<f64>,
    lowest: Vec<f64>,
    highest: Vec<f64>,
    increments: Vec<f64>,
    extent: f64,
}

/// How far along each Newton step the iteration goes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Search {
    /// All the way, with exact tangents only.
    Full,
    /// As far as the monotonicity test allows.
    Damped,
}

/// What the inner iteration ended with.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Outcome {
    Converged,
    /// With the relative residual it stopped at.
    Stuck(f64),
}

impl Newton {
    pub fn new(twin: &Twin) -> Self {
        let pattern = Arc::new(twin.body.stiffness_pattern(&twin.cables.couplings()));
        let (n, m) = (twin.body.n_unknowns(), twin.cables.len());
        let extent = |c: usize| {
            let along = twin.body.rest.iter().map(|node| node[c]);
            along.clone().fold(f64::MIN, f64::max) - along.fold(f64::MAX, f64::min)
        };
        Self {
            factor: StiffnessFactor::new(&pattern, FactorKind::Supernodal, twin.body.isa),
            stiffness: Stiffness::zeros(pattern),
            projection: Projection::new(n, m),
            qp: BoxQp::new(m),
            trial: twin.rest(),
            drift: vec![0.0; n],
            displacement: vec![0.0; n],
            correction: vec![0.0; n],
            right: vec![0.0; m],
            lowest: vec![0.0; m],
            highest: vec![0.0; m],
            increments: vec![0.0; m],
            extent: (0..3).map(extent).fold(0.0, f64::max),
        }
    }

    /// Iterates from `state` to `control`; `state` is left anywhere when stuck.
    pub fn run(
        &mut self,
        twin: &Twin,
        control: &Control,
        state: &mut TwinState,
        balance: &mut Balance,
        search: Search,
        report: &mut StepReport,
    ) -> Outcome {
        let (most, kinds): (_, &[Tangent]) = match search {
            Search::Full => (MAX_FULL_STEPS, &[Tangent::Exact]),
            Search::Damped => (MAX_ITERATIONS, &[Tangent::Exact, Tangent::Warped]),
        };
        for j in 0..state.tensions.len() {
            state.tensions[j] = state.tensions[j].clamp(control.lowest[j], control.highest[j]);
        }
        balance.evaluate(twin, control, &state.positions, &state.tensions);
        for _ in 0..most {
            if balance.is_met(twin) {
                return Outcome::Converged;
            }
            report.newton_iterations += 1;
            if !balance.is_finite()
                || balance.relative > DIVERGED
                || self.linearise(twin, state, balance, kinds).is_err()
                || !self.solve_tensions(twin, control, state, balance, report)
                || !self.move_along(twin, control, state, balance, search)
            {
                break;
            }
        }
        if balance.is_met(twin) { Outcome::Converged } else { Outcome::Stuck(balance.relative) }
    }

    /// Factorises a tangent at `state`, for which `balance` was evaluated, with the cables' part, and
    /// projects it: the first of `kinds` that has a factor.
    ///
    /// # Errors
    /// None of them has.
    pub fn linearise(
        &mut self,
        twin: &Twin,
        state: &TwinState,
        balance: &Balance,
        kinds: &[Tangent],
    ) -> hysteron_fem::Result<()> {
        let pattern = self.stiffness.pattern.clone();
        let mut result = Ok(());
        for kind in kinds {
            twin.body.stiffness_into(&state.positions, *kind, &mut self.stiffness);
            twin.cables.add_stiffness(&balance.shape, &state.tensions, &pattern, &mut self.stiffness);
            result = self.factor.factorize(&self.stiffness);
            if result.is_ok() {
                break;
            }
        }
        result?;
        self.projection.update(&twin.cables, &balance.shape, &mut self.factor);
        self.drift.copy_from_slice(&balance.residual);
        self.factor.solve(&mut self.drift);
        Ok(())
    }

    /// Tension increments from the QP, and the displacement they make with the drift.
    fn solve_tensions(
        &mut self,
        twin: &Twin,
        control: &Control,
        state: &TwinState,
        balance: &Balance,
        report: &mut StepReport,
    ) -> bool {
        for j in 0..state.tensions.len() {
            self.right[j] = balance.missing[j] + twin.cables.row_times(&balance.shape, j, &self.drift);
            self.lowest[j] = control.lowest[j] - state.tensions[j];
            self.highest[j] = control.highest[j] - state.tensions[j];
        }
        self.qp.set_matrix(&self.projection.delassus);
        let (status, solver) = self.qp.solve(&self.right, &self.lowest, &self.highest, &mut self.increments);
        report.clarabel_solves += usize::from(solver == QpSolver::Clarabel);
        status == QpStatus::Solved
    }

    /// Moves along the Newton step as far as `search` allows.
    fn move_along(
        &mut self,
        twin: &Twin,
        control: &Control,
        state: &mut TwinState,
        balance: &mut Balance,
        search: Search,
    ) -> bool {
        for (displacement, drift) in self.displacement.iter_mut().zip(&self.drift) {
            *displacement = -drift;
        }
        for (increment, column) in self.increments.iter().zip(&self.projection.columns) {
            hysteron_fem::axpy(twin.body.isa, *increment, column, &mut self.displacement);
        }
        let longest = self.displacement.iter().fold(0.0f64, |max, d| max.max(d.abs()));
        let mut part = (LONGEST_MOVE * self.extent / longest).min(1.0);
        let present = self.merit(balance, &self.drift.clone());
        let best_seen = balance.relative;
        while part >= SHORTEST {
            self.trial.clone_from(state);
            move_nodes(&mut self.trial.positions, part, &self.displacement);
            for j in 0..state.tensions.len() {
                let bounds = (control.lowest[j], control.highest[j]);
                // A full step lands exactly on its bound.
                self.trial.tensions[j] = if part == 1.0 && self.increments[j] == self.lowest[j] {
                    bounds.0
                } else {
                    (state.tensions[j] + part * self.increments[j]).clamp(bounds.0, bounds.1)
                };
            }
            balance.evaluate(twin, control, &self.trial.positions, &self.trial.tensions);
            if search == Search::Full {
                std::mem::swap(state, &mut self.trial);
                return true;
            }
            if balance.is_finite() {
                self.correction.copy_from_slice(&balance.residual);
                self.factor.solve(&mut self.correction);
                let correction = std::mem::take(&mut self.correction);
                let trial = self.merit(balance, &correction);
                self.correction = correction;
                // The relative residual decides once the merit is lost in round-off.
                if trial <= (1.0 - 0.25 * part) * present || balance.relative < 0.5 * best_seen {
                    std::mem::swap(state, &mut self.trial);
                    return true;
                }
            }
            part *= 0.5;
        }
        balance.evaluate(twin, control, &state.positions, &state.tensions);
        false
    }

    /// Energy of the corrections still to be made: rᵀ K⁻¹ r plus that of the missing strokes [J].
    fn merit(&self, balance: &Balance, solved: &[f64]) -> f64 {
        let n = self.right.len();
        let forces: f64 = balance.residual.iter().zip(solved).map(|(r, z)| r * z).sum();
        let strokes: f64 = (0..n)
            .filter(|&j| self.increments[j] != self.lowest[j])
            .map(|j| balance.missing[j].powi(2) / self.projection.delassus[j * (n + 1)])
            .sum();
        (forces + strokes).sqrt()
    }
}
