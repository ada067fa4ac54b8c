//! The common case of a step: a lagged single-precision factor, a good guess, one or two corrections.
//!
//! Each iteration solves once with the factor of an earlier configuration, z = K⁻¹ r, finds the tension
//! increments from the bound-constrained QP in W, and moves by Y dT - z; Anderson acceleration makes up
//! for the factor's age. The residual itself is always exact, so what converges is an equilibrium. The
//! factor is that of the rest stiffness turned with each element: without the geometric terms of body
//! and cables, which nearly cancel under internal loads, it is positive definite and keeps a narrow
//! envelope. It is replaced when the latest steps cost more iterations than the average step since the last
//! refactorisation, the refactorisation included.

use std::sync::Arc;

use hysteron_fem::vectors::combine_into;
use hysteron_fem::{FactorKind, Stiffness, StiffnessFactor, Tangent};

use crate::anderson::Anderson;
use crate::cable::CableShape;
use crate::equilibrium_residual::{EquilibriumResidual, StepTargets, move_nodes};
use crate::error::Cause;
use crate::model::Twin;
use crate::predictor::{EquilibriumPredictor, Prescribed};
use crate::projection::Projection;
use crate::report::StepReport;
use crate::state::TwinState;
use crate::tensions::TensionStep;
use hysteron_fit::qp::{Activity, QpSolver};

/// Iterations after which a factor is replaced within a step, and after which the step is given up.
const REFACTORISE_AFTER: usize = 8;
const GIVE_UP_AFTER: usize = 40;
/// Growth of the residual over the best one so far that counts as divergence.
const DIVERGED: f64 = 1e3;

/// Factor, projection and history of the fast iteration; scratch.
#[derive(Debug, Clone)]
pub(crate) struct QuasiNewton {
    stiffness: Stiffness,
    factor: StiffnessFactor,
    projection: Projection,
    /// The projection's columns in single precision: they are streamed in every iteration.
    columns: Vec<Vec<f32>>,
    tensions: TensionStep,
    anderson: Anderson,
    predictor: EquilibriumPredictor,
    /// No factor yet, or one that did not serve.
    is_unusable: bool,
    /// Cost of a refactorisation, in iterations [-].
    refactorisation_cost: f64,
    /// Iterations and steps since the last refactorisation.
    spent: usize,
    steps: usize,
    /// Iterations of the last steps, the latest weighing one half.
    recent: f64,
    /// Free displacement, then tension increments times their mean compliance.
    step: Vec<f64>,
    /// K⁻¹ r.
    free_displacement: Vec<f64>,
    prescribed: Vec<Prescribed>,
    /// Status of each cable in the last QP.
    active_set: Vec<Activity>,
}

impl QuasiNewton {
    pub fn new(twin: &Twin) -> Self {
        let pattern = Arc::new(twin.body.stiffness_pattern(&[]));
        let kind = FactorKind::fastest(&pattern);
        let (n, m, isa) = (twin.body.n_unknowns(), twin.cables.len(), twin.body.isa);
        let factor = StiffnessFactor::new(&pattern, kind, isa);
        Self {
            refactorisation_cost: refactorisation_cost(n, m, twin.body.cells.len(), factor.n_stored()),
            factor,
            stiffness: Stiffness::zeros(pattern),
            projection: Projection::new(n, m),
            columns: vec![vec![0.0; n]; m],
            tensions: TensionStep::new(m),
            anderson: Anderson::new(isa, n, m),
            predictor: EquilibriumPredictor::new(isa, n, m),
            is_unusable: true,
            spent: 0,
            steps: 0,
            recent: 0.0,
            step: vec![0.0; n + m],
            free_displacement: vec![0.0; n],
            prescribed: Vec::with_capacity(m),
            active_set: vec![Activity::Free; m],
        }
    }

    /// Y and W of the factor in use, or of a new one at `state`.
    pub fn projection(
        &mut self,
        twin: &Twin,
        state: &TwinState,
        balance: &EquilibriumResidual,
    ) -> Option<&Projection> {
        let usable =
            !self.is_unusable || self.refactorise(twin, state, balance, &mut StepReport::default()).is_ok();
        usable.then_some(&self.projection)
    }

    /// Y and W of the factor in use, however old.
    pub fn last_projection(&self) -> &Projection {
        &self.projection
    }

    /// Replaces a force by the displacement that the factor in use gives it.
    pub fn solve(&mut self, force: &mut [f64]) {
        self.factor.solve(force);
    }

    /// A new factor between steps pays never.
    #[cfg(test)]
    pub fn disable_refactorisation(&mut self) {
        self.refactorisation_cost = f64::INFINITY;
    }

    /// The factor in use is of no use where the state is now.
    pub fn invalidate(&mut self) {
        self.is_unusable = true;
    }

    /// The state has jumped: history and factor no longer fit.
    pub fn reset(&mut self) {
        self.predictor.clear();
        self.anderson.clear();
        self.is_unusable = true;
    }

    /// Moves the equilibrium `state` to that of `control`; where it fails, `state` is left anywhere.
    pub fn run(
        &mut self,
        twin: &Twin,
        control: &StepTargets,
        state: &mut TwinState,
        balance: &mut EquilibriumResidual,
        report: &mut StepReport,
    ) -> Result<(), Cause> {
        if self.is_unusable {
            balance.evaluate_strokes(twin, control, &state.positions, &state.tensions);
            self.refactorise(twin, state, balance, report)?;
        }
        self.predict(twin, control, state, balance);
        self.anderson.begin();
        let mut best = f64::INFINITY;
        let mut refactorised_at = 0;
        for iteration in 0..GIVE_UP_AFTER {
            balance.evaluate(twin, control, &state.positions, &state.tensions);
            if !balance.is_finite() || balance.relative > DIVERGED * best {
                return Err(Cause::Diverged);
            }
            if balance.is_balanced(twin) {
                if !balance.is_upright {
                    let element =
                        twin.body.first_inverted(&state.positions).map_or(0, |(element, _)| element);
                    return Err(Cause::Inverted { element });
                }
                self.finish(twin, &balance.shape, state, iteration);
                return Ok(());
            }
            best = best.min(balance.relative);
            if iteration - refactorised_at == REFACTORISE_AFTER {
                self.refactorise(twin, state, balance, report)?;
                refactorised_at = iteration;
            }
            self.iterate(twin, control, state, balance, report)?;
        }
        Err(Cause::IterationLimit)
    }

    /// Factor, Y and W at the present configuration (`balance` holds its cable shape).
    fn refactorise(
        &mut self,
        twin: &Twin,
        state: &TwinState,
        balance: &EquilibriumResidual,
        report: &mut StepReport,
    ) -> Result<(), Cause> {
        report.refactorisations += 1;
        self.is_unusable = true;
        twin.body.stiffness_into(&state.positions, Tangent::Warped, &mut self.stiffness);
        self.factor.factorize(&self.stiffness).map_err(|_| Cause::NoFactor)?;
        self.projection.update(&twin.cables, &balance.shape, &mut self.factor);
        for (single, double) in self.columns.iter_mut().zip(&self.projection.columns) {
            for (single, double) in single.iter_mut().zip(double) {
                *single = *double as f32;
            }
        }
        self.tensions.qp.set_matrix(&self.projection.delassus);
        self.anderson.clear();
        self.is_unusable = false;
        self.spent = 0;
        self.steps = 0;
        self.recent = 0.0;
        Ok(())
    }

    /// Moves `state` to where the history expects the equilibrium, then onto the commanded strokes.
    fn predict(
        &mut self,
        twin: &Twin,
        control: &StepTargets,
        state: &mut TwinState,
        balance: &mut EquilibriumResidual,
    ) {
        let (n, m) = (self.free_displacement.len(), state.tensions.len());
        self.step.fill(0.0);
        self.prescribed.clear();
        for j in 0..m {
            let prescribed = match self.active_set[j] {
                Activity::Free if !control.is_tension(j) => Prescribed::Stroke(control.strokes[j]),
                Activity::AtUpper => Prescribed::Tension(control.upper[j], self.compliance(j)),
                _ => Prescribed::Tension(control.lower[j], self.compliance(j)),
            };
            self.prescribed.push(prescribed);
        }
        self.predictor.predict(&self.prescribed, &mut self.step);
        // Prescribed tensions that the history does not explain move the body by Y dT.
        for j in 0..m {
            let expected = state.tensions[j] + self.step[n + j];
            state.tensions[j] = expected.clamp(control.lower[j], control.upper[j]);
            self.tensions.increments[j] = state.tensions[j] - expected;
        }
        self.move_by_tensions(twin);
        move_nodes(&mut state.positions, 1.0, &self.step[..n]);
        balance.evaluate_strokes(twin, control, &state.positions, &state.tensions);
        self.free_displacement.fill(0.0);
        if self.solve_tensions(twin, control, state, balance).is_ok() {
            self.step.fill(0.0);
            self.move_by_tensions(twin);
            move_nodes(&mut state.positions, 1.0, &self.step[..n]);
            TensionStep::apply(control, &self.tensions.increments, 1.0, &mut state.tensions);
        }
    }

    /// One correction.
    fn iterate(
        &mut self,
        twin: &Twin,
        control: &StepTargets,
        state: &mut TwinState,
        balance: &EquilibriumResidual,
        report: &mut StepReport,
    ) -> Result<(), Cause> {
        let (n, m) = (self.free_displacement.len(), state.tensions.len());
        report.iterations += 1;
        self.free_displacement.copy_from_slice(&balance.residual);
        self.factor.solve(&mut self.free_displacement);
        let solver = self.solve_tensions(twin, control, state, balance)?;
        report.clarabel_solves += usize::from(solver == QpSolver::Clarabel);
        for (step, free_displacement) in self.step.iter_mut().zip(&self.free_displacement) {
            *step = -free_displacement;
        }
        self.move_by_tensions(twin);
        let active_set = self.tensions.qp.active_set();
        let has_changed = self.active_set != active_set;
        self.active_set.copy_from_slice(active_set);
        for j in 0..m {
            self.step[n + j] = self.tensions.increments[j] * self.compliance(j);
        }
        self.anderson.observe(&self.step, &self.free_displacement, &self.tensions.stroke_residual);
        if has_changed {
            self.revise_pairs(twin);
        }
        self.anderson.accelerate(&mut self.step);
        move_nodes(&mut state.positions, 1.0, &self.step[..n]);
        for j in 0..m {
            self.tensions.increments[j] = self.step[n + j] / self.compliance(j);
        }
        TensionStep::apply(control, &self.tensions.increments, 1.0, &mut state.tensions);
        self.anderson.moved(&self.step);
        Ok(())
    }

    /// Adds the displacement Y dT of the increments to the step.
    fn move_by_tensions(&mut self, twin: &Twin) {
        let n = self.free_displacement.len();
        combine_into(twin.body.isa, &self.tensions.increments, &self.columns, &mut self.step[..n]);
    }

    /// Revises the effect of the pairs' moves on the step, with each cable in the active set of the last QP.
    fn revise_pairs(&mut self, twin: &Twin) {
        let Self { anderson, tensions, projection, columns, .. } = self;
        let (n, m) = (self.free_displacement.len(), self.active_set.len());
        let compliance = |j: usize| projection.delassus[j * (m + 1)];
        let increments = &mut tensions.increments;
        let mut is_known = true;
        anderson.revise(|pair| {
            // A cable at a bound is proposed to go there, wherever it is.
            for j in 0..m {
                increments[j] = -pair.moved[n + j] / compliance(j);
            }
            is_known &= tensions.qp.respond(&pair.stroke_residual, increments);
            for (change, free_displacement) in pair.change.iter_mut().zip(&pair.free_displacement) {
                *change = -free_displacement;
            }
            combine_into(twin.body.isa, increments, columns, &mut pair.change[..n]);
            for j in 0..m {
                pair.change[n + j] = increments[j] * compliance(j);
            }
        });
        if !is_known {
            anderson.clear();
        }
    }

    /// The QP of eq. 4 for the tension increments, with the free displacement already known.
    fn solve_tensions(
        &mut self,
        twin: &Twin,
        control: &StepTargets,
        state: &TwinState,
        balance: &EquilibriumResidual,
    ) -> Result<QpSolver, Cause> {
        let free_displacement = &self.free_displacement;
        let stroke_residual = |j: usize| {
            balance.stroke_residual[j] + twin.cables.row_times(&balance.shape, j, free_displacement)
        };
        self.tensions.pose(control, &state.tensions, stroke_residual);
        self.tensions.solve().map_err(Cause::Qp)
    }

    /// W_jj [m/N].
    fn compliance(&self, j: usize) -> f64 {
        self.projection.delassus[j * (self.active_set.len() + 1)]
    }

    /// Commits the equilibrium and decides whether the factor is worth keeping.
    fn finish(&mut self, twin: &Twin, shape: &CableShape, state: &TwinState, iterations: usize) {
        let n_free = self.free_displacement.len() / 3;
        self.predictor.push(|to_strokes, to_point| {
            for (j, stroke) in to_strokes.iter_mut().enumerate() {
                *stroke = twin.cables.pulled(shape, j, &state.tensions);
            }
            let (positions, tensions) = to_point.split_at_mut(3 * n_free);
            for (point, node) in positions.as_chunks_mut::<3>().0.iter_mut().zip(&state.positions) {
                point.copy_from_slice(&node[..3]);
            }
            tensions.copy_from_slice(&state.tensions);
        });
        self.spent += iterations;
        self.steps += 1;
        self.recent = 0.5 * (self.recent + iterations as f64);
        self.is_unusable = self.recent * self.steps as f64 > self.refactorisation_cost + self.spent as f64;
    }
}

/// Cost of a refactorisation over that of an iteration, for `n` unknowns, `m` cables and a factor of `stored`
/// numbers.
///
/// Estimated from counts rather than measured, so that every run makes the same decisions; the rates are
/// those of the benchmarks `force`, `assembly`, `factor` and `solve` on one core.
fn refactorisation_cost(n: usize, m: usize, n_elements: usize, stored: usize) -> f64 {
    const FORCE: f64 = 12e-9; // s per element
    const ASSEMBLY: f64 = 65e-9; // s per element
    const VECTORS: f64 = 6e-9; // s per unknown: norms, acceleration, cables
    const FACTOR: f64 = 60e9; // multiply-adds per s
    const PANEL: f64 = 50e9; // multiply-adds per s, many right-hand sides
    // Multiply-adds per s, one right-hand side: limited by the cache, then by memory.
    let solve = if stored < 4_000_000 { 25e9 } else { 8e9 };
    let (n, m, n_elements, stored) = (n as f64, m as f64, n_elements as f64, stored as f64);
    let refactorisation =
        ASSEMBLY * n_elements + stored * stored / (2.0 * n * FACTOR) + 2.0 * m * stored / PANEL;
    refactorisation / (FORCE * n_elements + VECTORS * n + 2.0 * stored / solve)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenes;
    use crate::{Stepper, Target};

    #[test]
    fn pairs_rebuilt_without_a_change_of_the_active_set_are_those_observed() {
        let (mut scene, mesh) = scenes::robot();
        scene.tendons[0].compliance = 1e-5;
        let twin = Twin::new(&scene, &mesh).expect("a good scene");
        let mut stepper = Stepper::new(&twin);
        // One pulled, one slack, one driven by tension, one held.
        for k in 1..=6 {
            let part = 2e-4 * f64::from(k);
            let targets = [part, -part, 0.0, 0.0].map(Target::Stroke);
            let targets = [targets[0], targets[1], Target::Tension(500.0 * part), targets[3]];
            stepper.step(&twin, &targets).expect("an equilibrium");
        }
        let fast = stepper.fast_iteration();
        let observed = fast.anderson.changes();
        fast.revise_pairs(&twin);
        let again = fast.anderson.changes();
        assert!(observed.len() > 1, "{} pairs", observed.len());
        for (observed, again) in observed.iter().zip(&again) {
            let size = observed.iter().map(|c| c * c).sum::<f64>().sqrt();
            let apart = observed.iter().zip(again).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
            // The same sums in another order: round-off of steps up to a million times as long as their difference.
            assert!(apart < 1e6 * 1e-15 * size, "{apart} of {size}");
        }
    }
}
