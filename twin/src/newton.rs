//! The robust case of a step: exact tangent, line search, sub-steps.
//!
//! The tangent includes the geometric stiffness of body and cables, factorised in double precision. Full
//! steps are tried first: a slender body that turns is stretched by every Newton step, which the next one
//! undoes, but no test on the way allows. Beyond a limit point, where a tendon's tension falls while its
//! stroke grows, the tangent itself is indefinite, but not on the displacements that keep the taut
//! tendons' strokes: there the step uses a signed factor, and an equilibrium counts when tangent and
//! Delassus operator have equally many negative eigenvalues. Then, from the start and on a smaller part of
//! the step, a trial is accepted by the natural monotonicity test: the correction that the present factor
//! and QP would make at the trial point must be smaller than the present one. Where the body is about to
//! snap or wrinkle, corrections first grow; a definite tangent then gives a direction along which the
//! potential energy falls, and a trial that lowers it enough is accepted too. One that inverts an element never is.
//!
//! # Reference
//! Deuflhard (2011), Newton methods for nonlinear problems, sec. 3.1. Haynsworth (1968), Determination of the
//! inertia of a partitioned Hermitian matrix, Linear Algebra Appl. 1 (the count of eigenvalues).

use std::sync::Arc;

use hysteron_fem::vectors::{axpy, dot};
use hysteron_fem::{FactorKind, Stiffness, StiffnessFactor, Tangent};

use crate::equilibrium_residual::{EquilibriumResidual, StepTargets, move_nodes};
use crate::error::Cause;
use crate::gmres::gmres;
use crate::model::Twin;
use crate::projection::Projection;
use crate::report::StepReport;
use crate::solver::Stuck;
use crate::state::TwinState;
use crate::tensions::TensionStep;
use hysteron_fit::qp::QpSolver;

const MAX_ITERATIONS: usize = 100;
/// Full steps that are tried first.
const MAX_FULL_STEPS: usize = 30;
/// Residual over the applied forces from which full steps are given up.
const DIVERGED: f64 = 1e8;
/// Directions in which the turning of couples is taken into account.
const COUPLE_DIRECTIONS: usize = 8;
/// Shortest part of a Newton step that is tried.
const MIN_STEP_LENGTH: f64 = 1.0 / 64.0;
/// Longest displacement of one Newton step, relative to the body's extent.
const MAX_MOVE: f64 = 0.25;
/// Shares of the always definite tangent that are mixed in, least first, until there is a factor.
const DEFINITE_SHARES: [f64; 4] = [1.0 / 64.0, 1.0 / 16.0, 1.0 / 4.0, 1.0];
/// Part of the predicted fall of energy that a trial must show (Armijo).
const ENOUGH: f64 = 1e-3;

/// Exact tangent, its factor and projection; scratch.
#[derive(Debug, Clone)]
pub(crate) struct Newton {
    stiffness: Stiffness,
    /// The exact tangent, and its mixture with the definite one, where it has no factor itself.
    exact: Stiffness,
    mixed: Stiffness,
    factor: StiffnessFactor,
    /// Negative eigenvalues of the factorised tangent.
    n_negative: usize,
    pub projection: Projection,
    tensions: TensionStep,
    trial: TwinState,
    /// K⁻¹ r.
    free_displacement: Vec<f64>,
    displacement: Vec<f64>,
    correction: Vec<f64>,
    extent: f64,
    /// An element that a trial has inverted.
    inverted: Option<usize>,
}

/// How far along each Newton step the iteration goes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum StepSearch {
    /// All the way, with exact tangents only.
    Full,
    /// As far as monotonicity or energy allow.
    Damped,
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
            n_negative: 0,
            exact: Stiffness::zeros(pattern.clone()),
            mixed: Stiffness::zeros(pattern.clone()),
            stiffness: Stiffness::zeros(pattern),
            projection: Projection::new(n, m),
            tensions: TensionStep::new(m),
            trial: twin.rest(),
            free_displacement: vec![0.0; n],
            displacement: vec![0.0; n],
            correction: vec![0.0; n],
            extent: (0..3).map(extent).fold(0.0, f64::max),
            inverted: None,
        }
    }

    /// Iterates from `state` to `control`; `state` is left anywhere when stuck.
    pub fn run(
        &mut self,
        twin: &Twin,
        control: &StepTargets,
        state: &mut TwinState,
        balance: &mut EquilibriumResidual,
        search: StepSearch,
        report: &mut StepReport,
    ) -> Result<(), Stuck> {
        let most = if search == StepSearch::Full { MAX_FULL_STEPS } else { MAX_ITERATIONS };
        for j in 0..state.tensions.len() {
            state.tensions[j] = state.tensions[j].clamp(control.lower[j], control.upper[j]);
        }
        self.inverted = None;
        balance.evaluate(twin, control, &state.positions, &state.tensions);
        let mut ended = Cause::IterationLimit;
        for _ in 0..most {
            if balance.is_balanced(twin) {
                break;
            }
            report.newton_iterations += 1;
            if let Err(cause) = self.iterate(twin, control, state, balance, search, report) {
                ended = cause;
                break;
            }
        }
        if balance.is_met(twin) {
            return Ok(());
        }
        if !balance.is_upright {
            self.inverted = twin.body.first_inverted(&state.positions).map(|(element, _)| element);
        }
        let cause = self.inverted.map_or(ended, |element| Cause::Inverted { element });
        Err(Stuck { relative_residual: balance.relative, cause })
    }

    /// One Newton iteration.
    fn iterate(
        &mut self,
        twin: &Twin,
        control: &StepTargets,
        state: &mut TwinState,
        balance: &mut EquilibriumResidual,
        search: StepSearch,
        report: &mut StepReport,
    ) -> Result<(), Cause> {
        if !balance.is_finite() || balance.relative > DIVERGED {
            return Err(Cause::Diverged);
        }
        self.linearise(twin, state, balance, search).map_err(|_| Cause::NoFactor)?;
        self.solve_tensions(twin, control, state, balance, report)?;
        self.advance(twin, control, state, balance, search)
    }

    /// Factorises the tangent at `state`, for which `balance` was evaluated, with the cables' part, and
    /// projects it. Where the exact one is indefinite, a damped search gets it mixed with the always
    /// definite one, no more than needed.
    ///
    /// # Errors
    /// No factor.
    pub fn linearise(
        &mut self,
        twin: &Twin,
        state: &TwinState,
        balance: &EquilibriumResidual,
        search: StepSearch,
    ) -> hysteron_fem::Result<()> {
        self.assemble(twin, state, balance, Tangent::Exact);
        let mut result = self.factor.factorize(&self.stiffness);
        self.n_negative = 0;
        if result.is_err() && search == StepSearch::Full {
            result = self.factor.factorize_signed(&self.stiffness).map(|negative| self.n_negative = negative);
        } else if result.is_err() {
            std::mem::swap(&mut self.stiffness, &mut self.exact);
            self.assemble(twin, state, balance, Tangent::Warped);
            for share in DEFINITE_SHARES {
                self.mixed.set_mixture(&self.exact, &self.stiffness, share);
                result = self.factor.factorize(&self.mixed);
                if result.is_ok() {
                    break;
                }
            }
        }
        result?;
        self.projection.update(&twin.cables, &balance.shape, &mut self.factor);
        self.free_displacement.copy_from_slice(&balance.residual);
        self.factor.solve(&mut self.free_displacement);
        Ok(())
    }

    fn assemble(&mut self, twin: &Twin, state: &TwinState, balance: &EquilibriumResidual, kind: Tangent) {
        let pattern = self.stiffness.pattern.clone();
        twin.body.stiffness_into(&state.positions, kind, &mut self.stiffness);
        twin.cables.add_stiffness(&balance.shape, &state.tensions, &pattern, &mut self.stiffness);
    }

    /// Makes the free displacement solve (K - C) z = r, where C is the derivative of the couples' forces, which no
    /// symmetric factor holds: minimal residuals over K⁻¹ r, K⁻¹ C K⁻¹ r, … Only the turns of the loaded
    /// sections count in C, so a few directions are enough.
    fn follow_couples(&mut self, twin: &Twin, load: f64, state: &TwinState) {
        let mut free_displacement = std::mem::take(&mut self.free_displacement);
        if free_displacement.iter().any(|z| *z != 0.0) && free_displacement.iter().all(|z| z.is_finite()) {
            // Arnoldi's iteration on 1 - K⁻¹ C.
            (free_displacement, _) =
                gmres(twin.body.isa, &free_displacement, (0.0, COUPLE_DIRECTIONS), |v| {
                    let mut image = self.couple_change(twin, load, state, v);
                    self.factor.solve(&mut image);
                    image.iter_mut().zip(v).for_each(|(image, v)| *image = v - *image);
                    image
                });
        }
        self.free_displacement = free_displacement;
    }

    /// Change of the couples' forces when the nodes move along `direction`, per unit of it.
    fn couple_change(&self, twin: &Twin, load: f64, state: &TwinState, direction: &[f64]) -> Vec<f64> {
        let longest = direction.iter().fold(0.0f64, |max, d| max.max(d.abs()));
        let step = 1e-6 * self.extent / longest;
        let mut forces = vec![[0.0; 4]; state.positions.len()];
        for sign in [1.0, -1.0] {
            let mut moved = state.positions.clone();
            move_nodes(&mut moved, sign * step, direction);
            for couple in &twin.couples {
                couple.add_forces(&moved, sign * load / (2.0 * step), &mut forces);
            }
        }
        forces.iter().take(direction.len() / 3).flat_map(|force| force[..3].to_vec()).collect()
    }

    /// Tension increments from the QP, and the displacement they make with the free displacement.
    fn solve_tensions(
        &mut self,
        twin: &Twin,
        control: &StepTargets,
        state: &TwinState,
        balance: &EquilibriumResidual,
        report: &mut StepReport,
    ) -> Result<(), Cause> {
        if !twin.couples.is_empty() {
            self.follow_couples(twin, control.load, state);
        }
        let free_displacement = &self.free_displacement;
        let stroke_residual = |j: usize| {
            balance.stroke_residual[j] + twin.cables.row_times(&balance.shape, j, free_displacement)
        };
        self.tensions.pose(control, &state.tensions, stroke_residual);
        if self.n_negative > 0 {
            return self.tensions.solve_taut(&self.projection.delassus, self.n_negative);
        }
        self.tensions.qp.set_matrix(&self.projection.delassus);
        let solver = self.tensions.solve().map_err(Cause::Qp)?;
        report.clarabel_solves += usize::from(solver == QpSolver::Clarabel);
        Ok(())
    }

    /// Moves along the Newton step as far as `search` allows.
    fn advance(
        &mut self,
        twin: &Twin,
        control: &StepTargets,
        state: &mut TwinState,
        balance: &mut EquilibriumResidual,
        search: StepSearch,
    ) -> Result<(), Cause> {
        for (displacement, free_displacement) in self.displacement.iter_mut().zip(&self.free_displacement) {
            *displacement = -free_displacement;
        }
        for (increment, column) in self.tensions.increments.iter().zip(&self.projection.columns) {
            axpy(twin.body.isa, *increment, column, &mut self.displacement);
        }
        let longest = self.displacement.iter().fold(0.0f64, |max, d| max.max(d.abs()));
        let mut step_length = (MAX_MOVE * self.extent / longest).min(1.0);
        let increments = self.tensions.increments.clone();
        if search == StepSearch::Full {
            self.try_step_length(twin, control, state, &increments, step_length, balance);
            std::mem::swap(state, &mut self.trial);
            return Ok(());
        }
        let present = self.size(twin, balance, &self.free_displacement, &increments);
        let (best_seen, was_upright) = (balance.relative, balance.is_upright);
        let strongest = self.strongest_tension(state);
        let energy = balance.potential(twin, control, &state.positions, strongest);
        let fall = self.predicted_fall(twin, control, state, balance, strongest);
        while step_length >= MIN_STEP_LENGTH {
            self.try_step_length(twin, control, state, &increments, step_length, balance);
            if was_upright && !balance.is_upright {
                self.inverted = twin.body.first_inverted(&self.trial.positions).map(|(element, _)| element);
                step_length *= 0.5;
                continue;
            }
            let is_closer = balance.is_finite() && {
                let trial = self.size_of_correction(twin, control, balance);
                // The relative residual decides once the corrections are lost in round-off.
                trial <= (1.0 - 0.25 * step_length) * present || balance.relative < 0.5 * best_seen
            };
            let falls = || {
                let trial = balance.potential(twin, control, &self.trial.positions, strongest);
                trial.zip(energy).is_some_and(|(trial, energy)| trial < energy - ENOUGH * step_length * fall)
            };
            if is_closer || balance.is_met(twin) || falls() {
                std::mem::swap(state, &mut self.trial);
                return Ok(());
            }
            step_length *= 0.5;
        }
        balance.evaluate(twin, control, &state.positions, &state.tensions);
        Err(Cause::LineSearch)
    }

    /// Makes `trial` the state after `step_length` of the step, and evaluates it.
    fn try_step_length(
        &mut self,
        twin: &Twin,
        control: &StepTargets,
        state: &TwinState,
        increments: &[f64],
        step_length: f64,
        balance: &mut EquilibriumResidual,
    ) {
        self.trial.clone_from(state);
        move_nodes(&mut self.trial.positions, step_length, &self.displacement);
        TensionStep::apply(control, increments, step_length, &mut self.trial.tensions);
        balance.evaluate(twin, control, &self.trial.positions, &self.trial.tensions);
    }

    /// Tension above which cables count as no stronger in the potential: an exact penalty must exceed the
    /// multipliers, and more would only shorten the steps.
    fn strongest_tension(&self, state: &TwinState) -> f64 {
        let tensions = state.tensions.iter().zip(&self.tensions.increments);
        2.0 * tensions.map(|(t, change)| t.abs().max((t + change).abs())).fold(0.0, f64::max)
    }

    /// How much the linearised potential falls over the full Newton step [J]; positive.
    fn predicted_fall(
        &self,
        twin: &Twin,
        control: &StepTargets,
        state: &TwinState,
        balance: &EquilibriumResidual,
        strongest: f64,
    ) -> f64 {
        // The residual contains the cables' forces, which the terms of the stroke penalty account for.
        let work: f64 = balance.residual.iter().zip(&self.displacement).map(|(r, d)| r * d).sum();
        let cables: f64 = (0..state.tensions.len())
            .map(|j| {
                let change = twin.cables.row_times(&balance.shape, j, &self.displacement);
                let stroke_residual = control.strokes[j] - balance.shape.strokes[j];
                let compliance = twin.cables.own_compliance(j);
                let stroke_penalty =
                    |stroke_residual: f64| control.stroke_penalty(j, stroke_residual, compliance, strongest);
                stroke_penalty(stroke_residual)
                    - stroke_penalty(stroke_residual - change)
                    - state.tensions[j] * change
            })
            .sum();
        (cables - work).max(0.0)
    }

    /// Size of the correction that the present factor would make at the trial point, the QP included;
    /// infinite without one.
    fn size_of_correction(
        &mut self,
        twin: &Twin,
        control: &StepTargets,
        balance: &EquilibriumResidual,
    ) -> f64 {
        self.correction.copy_from_slice(&balance.residual);
        self.factor.solve(&mut self.correction);
        let columns = &self.projection.columns;
        let stroke_residual =
            |j: usize| balance.stroke_residual[j] + dot(twin.body.isa, &balance.residual, &columns[j]);
        self.tensions.pose(control, &self.trial.tensions, stroke_residual);
        if self.tensions.solve().is_err() {
            return f64::INFINITY;
        }
        self.size(twin, balance, &self.correction, &self.tensions.increments)
    }

    /// Energy norm of the correction d = Y dT - z with z = K⁻¹ r: dᵀ K d = rᵀ z - 2 dTᵀ Yᵀ r + dTᵀ W dT
    /// [J], its root.
    fn size(&self, twin: &Twin, balance: &EquilibriumResidual, solved: &[f64], increments: &[f64]) -> f64 {
        let (isa, n) = (twin.body.isa, increments.len());
        let mut energy = dot(isa, &balance.residual, solved);
        for (i, (increment, column)) in increments.iter().zip(&self.projection.columns).enumerate() {
            let row = &self.projection.delassus[i * n..(i + 1) * n];
            let along: f64 = row.iter().zip(increments).map(|(w, dt)| w * dt).sum();
            energy += increment * (along - 2.0 * dot(isa, &balance.residual, column));
        }
        // Round-off may leave a little less than nothing.
        energy.max(0.0).sqrt()
    }
}
