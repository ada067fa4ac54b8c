//! The common case of a step: a stale single-precision factor, a good guess, one or two corrections.
//!
//! Each iteration solves once with the factor of an earlier configuration, z = K⁻¹ r, finds the tension
//! increments from the bound-constrained QP in W, and moves by Y dT - z; Anderson acceleration makes up
//! for the factor's age. The residual itself is always exact, so what converges is an equilibrium. The
//! factor is that of the rest stiffness turned with each element: without the geometric terms of body
//! and cables, which nearly cancel under internal loads, it is positive definite and keeps a narrow
//! envelope. It is renewed when the latest steps cost more iterations than the average step since the last
//! refactorisation, the refactorisation included.

use std::sync::Arc;

use hysteron_fem::{FactorKind, Stiffness, StiffnessFactor, Tangent, combine_into};

use crate::anderson::Anderson;
use crate::balance::{Balance, Control, move_nodes};
use crate::cable::CableShape;
use crate::model::Twin;
use crate::predictor::{Predictor, Told};
use crate::projection::Projection;
use crate::qp::{Place, QpSolver};
use crate::step::{StepReport, TwinState};
use crate::tensions::TensionStep;

/// Iterations after which a factor is renewed within a step, and after which the step is given up.
const RENEW_AFTER: usize = 8;
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
    predictor: Predictor,
    /// No factor yet, or one that did not serve.
    is_stale: bool,
    /// What a refactorisation costs, in iterations.
    renewal_cost: f64,
    /// Iterations and steps since the factor was renewed.
    spent: usize,
    steps: usize,
    /// Iterations of the last steps, the latest weighing one half.
    recent: f64,
    /// Free displacement, then tension increments times their mean compliance.
    step: Vec<f64>,
    /// K⁻¹ r.
    drift: Vec<f64>,
    told: Vec<Told>,
    /// Where each cable stood in the last QP.
    places: Vec<Place>,
}

impl QuasiNewton {
    pub fn new(twin: &Twin) -> Self {
        let pattern = Arc::new(twin.body.stiffness_pattern(&[]));
        let kind = FactorKind::fastest(&pattern);
        let (n, m, isa) = (twin.body.n_unknowns(), twin.cables.len(), twin.body.isa);
        let factor = StiffnessFactor::new(&pattern, kind, isa);
        Self {
            renewal_cost: renewal_cost(n, m, twin.body.cells.len(), factor.n_stored()),
            factor,
            stiffness: Stiffness::zeros(pattern),
            projection: Projection::new(n, m),
            columns: vec![vec![0.0; n]; m],
            tensions: TensionStep::new(m),
            anderson: Anderson::new(isa, n, m),
            predictor: Predictor::new(isa, n, m),
            is_stale: true,
            spent: 0,
            steps: 0,
            recent: 0.0,
            step: vec![0.0; n + m],
            drift: vec![0.0; n],
            told: Vec::with_capacity(m),
            places: vec![Place::Between; m],
        }
    }

    /// Y and W of the factor in use, or of a new one at `state`.
    pub fn projection(&mut self, twin: &Twin, state: &TwinState, balance: &Balance) -> Option<&Projection> {
        let usable = !self.is_stale || self.refactorise(twin, state, balance, &mut StepReport::default());
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
    pub fn never_pays(&mut self) {
        self.renewal_cost = f64::INFINITY;
    }

    /// The factor in use is of no use where the state is now.
    pub fn distrust(&mut self) {
        self.is_stale = true;
    }

    /// The state has jumped: history and factor no longer fit.
    pub fn forget(&mut self) {
        self.predictor.clear();
        self.anderson.clear();
        self.is_stale = true;
    }

    /// Tries to reach `control` from the equilibrium `state`; true when it did. Otherwise `state` is
    /// left anywhere.
    pub fn run(
        &mut self,
        twin: &Twin,
        control: &Control,
        state: &mut TwinState,
        balance: &mut Balance,
        report: &mut StepReport,
    ) -> bool {
        if self.is_stale {
            balance.evaluate_strokes(twin, control, &state.positions, &state.tensions);
            if !self.refactorise(twin, state, balance, report) {
                return false;
            }
        }
        self.predict(twin, control, state, balance);
        self.anderson.begin();
        let mut best = f64::INFINITY;
        let mut renewed_at = 0;
        for iteration in 0..GIVE_UP_AFTER {
            balance.evaluate(twin, control, &state.positions, &state.tensions);
            if !balance.is_finite() || balance.relative > DIVERGED * best {
                return false;
            }
            if balance.is_balanced(twin) {
                if balance.is_upright {
                    self.finish(twin, &balance.shape, state, iteration);
                }
                return balance.is_upright;
            }
            best = best.min(balance.relative);
            if iteration - renewed_at == RENEW_AFTER {
                if !self.refactorise(twin, state, balance, report) {
                    return false;
                }
                renewed_at = iteration;
            }
            if !self.iterate(twin, control, state, balance, report) {
                return false;
            }
        }
        false
    }

    /// Factor, Y and W at the present configuration (`balance` holds its cable shape).
    fn refactorise(
        &mut self,
        twin: &Twin,
        state: &TwinState,
        balance: &Balance,
        report: &mut StepReport,
    ) -> bool {
        report.refactorisations += 1;
        self.is_stale = true;
        twin.body.stiffness_into(&state.positions, Tangent::Warped, &mut self.stiffness);
        if self.factor.factorize(&self.stiffness).is_err() {
            return false;
        }
        self.projection.update(&twin.cables, &balance.shape, &mut self.factor);
        for (single, double) in self.columns.iter_mut().zip(&self.projection.columns) {
            for (single, double) in single.iter_mut().zip(double) {
                *single = *double as f32;
            }
        }
        self.tensions.qp.set_matrix(&self.projection.delassus);
        self.anderson.clear();
        self.is_stale = false;
        self.spent = 0;
        self.steps = 0;
        self.recent = 0.0;
        true
    }

    /// Moves `state` to where the history expects the equilibrium, then onto the commanded strokes.
    fn predict(&mut self, twin: &Twin, control: &Control, state: &mut TwinState, balance: &mut Balance) {
        let (n, m) = (self.drift.len(), state.tensions.len());
        self.step.fill(0.0);
        self.told.clear();
        for j in 0..m {
            let told = match self.places[j] {
                Place::Between if !control.is_tension(j) => Told::Stroke(control.strokes[j]),
                Place::Upper => Told::Tension(control.highest[j], self.compliance(j)),
                _ => Told::Tension(control.lowest[j], self.compliance(j)),
            };
            self.told.push(told);
        }
        self.predictor.predict(&self.told, &mut self.step);
        // Prescribed tensions that the history does not explain move the body by Y dT.
        for j in 0..m {
            let expected = state.tensions[j] + self.step[n + j];
            state.tensions[j] = expected.clamp(control.lowest[j], control.highest[j]);
            self.tensions.increments[j] = state.tensions[j] - expected;
        }
        self.move_by_tensions(twin);
        move_nodes(&mut state.positions, 1.0, &self.step[..n]);
        balance.evaluate_strokes(twin, control, &state.positions, &state.tensions);
        self.drift.fill(0.0);
        if self.solve_tensions(twin, control, state, balance).is_some() {
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
        control: &Control,
        state: &mut TwinState,
        balance: &Balance,
        report: &mut StepReport,
    ) -> bool {
        let (n, m) = (self.drift.len(), state.tensions.len());
        report.iterations += 1;
        self.drift.copy_from_slice(&balance.residual);
        self.factor.solve(&mut self.drift);
        match self.solve_tensions(twin, control, state, balance) {
            Some(QpSolver::ActiveSet) => {}
            Some(QpSolver::Clarabel) => report.clarabel_solves += 1,
            None => return false,
        }
        for (step, drift) in self.step.iter_mut().zip(&self.drift) {
            *step = -drift;
        }
        self.move_by_tensions(twin);
        let places = self.tensions.qp.places();
        let has_kink = self.places != places;
        self.places.copy_from_slice(places);
        for j in 0..m {
            self.step[n + j] = self.tensions.increments[j] * self.compliance(j);
        }
        self.anderson.observe(&self.step, &self.drift, &self.tensions.missing);
        if has_kink {
            self.revise_pairs(twin);
        }
        self.anderson.accelerate(&mut self.step);
        move_nodes(&mut state.positions, 1.0, &self.step[..n]);
        for j in 0..m {
            self.tensions.increments[j] = self.step[n + j] / self.compliance(j);
        }
        TensionStep::apply(control, &self.tensions.increments, 1.0, &mut state.tensions);
        self.anderson.moved(&self.step);
        true
    }

    /// Adds the displacement Y dT of the increments to the step.
    fn move_by_tensions(&mut self, twin: &Twin) {
        let n = self.drift.len();
        combine_into(twin.body.isa, &self.tensions.increments, &self.columns, &mut self.step[..n]);
    }

    /// What the pairs' moves do to the step with each cable where the last QP has put it.
    fn revise_pairs(&mut self, twin: &Twin) {
        let Self { anderson, tensions, projection, columns, .. } = self;
        let (n, m) = (self.drift.len(), self.places.len());
        let compliance = |j: usize| projection.delassus[j * (m + 1)];
        let increments = &mut tensions.increments;
        let mut is_known = true;
        anderson.revise(|pair| {
            // A cable at a bound is proposed to go there, wherever it is.
            for j in 0..m {
                increments[j] = -pair.moved[n + j] / compliance(j);
            }
            is_known &= tensions.qp.respond(&pair.missing, increments);
            for (change, drift) in pair.change.iter_mut().zip(&pair.drift) {
                *change = -drift;
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

    /// The QP of eq. 4 for the tension increments, with the drift already known.
    fn solve_tensions(
        &mut self,
        twin: &Twin,
        control: &Control,
        state: &TwinState,
        balance: &Balance,
    ) -> Option<QpSolver> {
        let drift = &self.drift;
        let missing = |j: usize| balance.missing[j] + twin.cables.row_times(&balance.shape, j, drift);
        self.tensions.pose(control, &state.tensions, missing);
        self.tensions.solve()
    }

    /// W_jj [m/N].
    fn compliance(&self, j: usize) -> f64 {
        self.projection.delassus[j * (self.places.len() + 1)]
    }

    /// Remembers the equilibrium and decides whether the factor is worth keeping.
    fn finish(&mut self, twin: &Twin, shape: &CableShape, state: &TwinState, iterations: usize) {
        let n_free = self.drift.len() / 3;
        self.predictor.push(|to_strokes, to_point| {
            for (j, stroke) in to_strokes.iter_mut().enumerate() {
                *stroke = shape.strokes[j] + twin.cables.stretch(j, &state.tensions);
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
        self.is_stale = self.recent * self.steps as f64 > self.renewal_cost + self.spent as f64;
    }
}

/// Cost of a refactorisation over that of an iteration, for `n` unknowns, `m` cables and a factor of `stored`
/// numbers.
///
/// Estimated from counts rather than measured, so that every run makes the same decisions; the rates are
/// those of the benchmarks `force`, `assembly`, `factor` and `solve` on one core.
fn renewal_cost(n: usize, m: usize, n_elements: usize, stored: usize) -> f64 {
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
    fn pairs_made_anew_without_a_kink_are_what_was_observed() {
        let (mut scene, mesh) = scenes::robot();
        scene.tendons[0].compliance = 1e-5;
        let twin = Twin::new(&scene, &mesh).expect("a good scene");
        let (mut stepper, mut state) = (Stepper::new(&twin), twin.rest());
        // One pulled, one slack, one driven by tension, one held.
        for k in 1..=6 {
            let part = 2e-4 * f64::from(k);
            let targets = [part, -part, 0.0, 0.0].map(Target::Stroke);
            let targets = [targets[0], targets[1], Target::Tension(500.0 * part), targets[3]];
            stepper.step(&twin, &targets, &mut state).expect("an equilibrium");
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
