//! Quasi-static steps of a chain: a lagged factor of the exact tangent, a prediction from the last equilibria, one or two
//! corrections; where that fails, parts of the step with a new factor in every iteration.

use std::sync::Arc;

use hysteron_fem::vectors::{combine_into, dot};
use hysteron_fit::qp::{Activity, QpSolver};
use nalgebra::{Matrix3, Vector3};

use super::balance::ChainBalance;
use super::band::{BlockSkyline, BlockVector, PanelBlock};
use super::body::Chain;
use super::rotation::{exp, log, orthonormal};
use super::tangent::TangentAssembly;
use super::{BLOCK, Interface, POSE};
use crate::Result;
use crate::anderson::Anderson;
use crate::equilibrium_residual::StepTargets;
use crate::error::Cause;
use crate::model::Twin;
use crate::predictor::{EquilibriumPredictor, Prescribed};
use crate::report::StepReport;
use crate::solver::{Balance, BodySolver, Stuck, TensionResponse, TipDerivatives, TipMotion, singular};
use crate::state::TwinState;
use crate::tensions::TensionStep;

/// Iterations after which a factor is replaced within a step, and after which the step is given up.
const REFACTORISE_AFTER: usize = 4;
const GIVE_UP_AFTER: usize = 24;
/// Growth of the residual over the best one so far that counts as divergence.
const DIVERGED: f64 = 1e3;
/// Iterations of Newton's method on a part of a step.
const MAX_NEWTON: usize = 12;
/// Residual over the applied forces from which it is given up.
const NEWTON_DIVERGED: f64 = 1e8;
/// Cost of a new factor, in iterations [-].
const REFACTORISATION_COST: f64 = 8.0;
/// Turn of an interface since the charts' origin at which a new origin is taken [rad].
const FAR_TURNED: f64 = 1.5;

/// The iterations of a chain; scratch.
#[derive(Debug, Clone)]
pub(crate) struct ChainSolver {
    pub(super) chain: Arc<Chain>,
    balance: ChainBalance,
    assembly: TangentAssembly,
    pub(super) tangent: BlockSkyline,
    /// Rows of J when the factor was made [-], and the columns of K⁻¹ Jᵀ [m/N].
    pub(super) rows: Vec<Vec<BlockVector>>,
    pub(super) columns: Vec<Vec<BlockVector>>,
    /// Derivatives of the tip's position by the unknowns when the factor was made [-]: rows, in the frame of the scene.
    pub(super) tip: [Vec<BlockVector>; 3],
    /// W + C, row-major [m/N].
    pub(super) delassus: Vec<f64>,
    /// Pulls of all cables at parts within sections; scratch.
    pulls: Vec<f64>,
    /// Columns side by side; scratch.
    pub(super) panel: Vec<PanelBlock>,
    /// Negative eigenvalues of the tangent.
    n_negative: usize,
    tensions: TensionStep,
    anderson: Anderson,
    predictor: EquilibriumPredictor,
    prescribed: Vec<Prescribed>,
    /// Origin of the charts of rotations.
    origin: Vec<Matrix3<f64>>,
    /// K⁻¹ r.
    free_displacement: Vec<BlockVector>,
    /// Change of the unknowns, then tension increments times their compliance [m].
    step: Vec<f64>,
    active_set: Vec<Activity>,
    is_unusable: bool,
    /// Iterations and steps since the last factor, and iterations of the last steps, the latest weighing one half.
    spent: usize,
    steps: usize,
    recent: f64,
}

impl ChainSolver {
    pub fn new(chain: &Arc<Chain>) -> Self {
        let (n, m, isa) = (chain.n_sections(), chain.cables.len(), chain.isa);
        let zeros = vec![[0.0; BLOCK]; n];
        let mut balance = ChainBalance::new(chain);
        balance.place(chain, &chain.rest);
        Self {
            chain: chain.clone(),
            balance,
            assembly: TangentAssembly::new(chain),
            tangent: TangentAssembly::pattern(chain),
            rows: vec![zeros.clone(); m],
            columns: vec![zeros.clone(); m],
            tip: [const { Vec::new() }; 3].map(|_: Vec<f64>| zeros.clone()),
            delassus: vec![0.0; m * m],
            pulls: Vec::new(),
            panel: Vec::new(),
            n_negative: 0,
            tensions: TensionStep::new(m),
            anderson: Anderson::new(isa, n * BLOCK, m),
            predictor: EquilibriumPredictor::new(isa, n * BLOCK, m),
            prescribed: Vec::with_capacity(m),
            origin: vec![Matrix3::identity(); n],
            free_displacement: zeros,
            step: vec![0.0; n * BLOCK + m],
            active_set: vec![Activity::Free; m],
            is_unusable: true,
            spent: 0,
            steps: 0,
            recent: 0.0,
        }
    }

    fn run(
        &mut self,
        (chain, control): (&Chain, &StepTargets),
        state: &mut TwinState,
        report: &mut StepReport,
    ) -> std::result::Result<(), Cause> {
        if self.is_unusable {
            self.balance.evaluate(chain, control, &state.interfaces, &state.tensions);
            self.refactorise(chain, state, report)?;
        }
        self.predict(chain, control, state);
        self.anderson.begin();
        let mut best = f64::INFINITY;
        let mut refactorised_at = 0;
        for iteration in 0..GIVE_UP_AFTER {
            self.balance.evaluate(chain, control, &state.interfaces, &state.tensions);
            if !self.balance.is_finite() || self.balance.relative > DIVERGED * best {
                return Err(Cause::Diverged);
            }
            if self.balance.is_met(chain) {
                self.finish(chain, state, iteration);
                return Ok(());
            }
            best = best.min(self.balance.relative);
            if iteration - refactorised_at == REFACTORISE_AFTER {
                self.refactorise(chain, state, report)?;
                refactorised_at = iteration;
            }
            report.iterations += 1;
            self.correct(chain, control, state, report)?;
            self.accelerate(chain, control, state);
        }
        Err(Cause::IterationLimit)
    }

    /// Factor, rows, columns and W at the configuration evaluated last.
    fn refactorise(
        &mut self,
        chain: &Chain,
        state: &TwinState,
        report: &mut StepReport,
    ) -> std::result::Result<(), Cause> {
        report.refactorisations += 1;
        self.is_unusable = true;
        self.assembly.assemble_into(chain, &self.balance, &state.tensions, &mut self.tangent);
        self.assembly.rows_into(chain, &chain.tip, &mut self.tip);
        self.n_negative = self.tangent.factorize().ok_or(Cause::NoFactor)?;
        let m = self.rows.len();
        for j in 0..m {
            self.balance.row_into(chain, j, &mut self.rows[j]);
            self.columns[j].copy_from_slice(&self.rows[j]);
        }
        self.tangent.solve_many(&mut self.columns, &mut self.panel);
        for j in 0..m {
            for i in 0..=j {
                let w = row_times(chain, &self.rows, i, &self.columns[j]);
                self.delassus[i * m + j] = w;
                self.delassus[j * m + i] = w;
            }
        }
        self.balance.add_sinks(chain, &mut self.delassus, &mut self.pulls);
        for (i, row) in chain.cables.compliance.iter().enumerate() {
            for &(j, compliance) in row {
                self.delassus[i * m + j] += compliance;
            }
        }
        if self.n_negative == 0 {
            self.tensions.qp.set_matrix(&self.delassus);
        }
        self.anderson.clear();
        self.is_unusable = false;
        (self.spent, self.steps, self.recent) = (0, 0, 0.0);
        Ok(())
    }

    /// Moves the state to where the history expects the equilibrium, then onto the commanded strokes.
    fn predict(&mut self, chain: &Chain, control: &StepTargets, state: &mut TwinState) {
        let (n, m) = (chain.n_unknowns(), state.tensions.len());
        self.prescribed.clear();
        for j in 0..m {
            self.prescribed.push(match self.active_set[j] {
                Activity::Free if !control.is_tension(j) => Prescribed::Stroke(control.strokes[j]),
                Activity::AtUpper => Prescribed::Tension(control.upper[j], self.compliance(j)),
                _ => Prescribed::Tension(control.lower[j], self.compliance(j)),
            });
        }
        self.step.fill(0.0);
        self.predictor.predict(&self.prescribed, &mut self.step);
        self.move_charts(chain, state);
        self.step[..n].fill(0.0);
        // Prescribed tensions that the history does not explain move the body by Y dT.
        for j in 0..m {
            let expected = state.tensions[j] + self.step[n + j];
            state.tensions[j] = expected.clamp(control.lower[j], control.upper[j]);
            self.tensions.increments[j] = state.tensions[j] - expected;
        }
        self.move_by_tensions(chain);
        self.apply(chain, state);
        self.balance.settle(chain, &state.interfaces, &state.tensions);
        self.balance.compare_strokes(chain, control, &state.tensions);
        self.free_displacement.fill([0.0; BLOCK]);
        if self.solve_tensions(chain, control, state, &mut StepReport::default()).is_ok() {
            self.step.fill(0.0);
            self.move_by_tensions(chain);
            self.apply(chain, state);
            TensionStep::apply(control, &self.tensions.increments, 1.0, &mut state.tensions);
        }
    }

    /// Moves the interfaces by a predicted change of their charts.
    fn move_charts(&mut self, chain: &Chain, state: &mut TwinState) {
        let charts = self.step.as_chunks::<BLOCK>().0;
        for ((interface, origin), change) in state.interfaces[1..].iter_mut().zip(&self.origin).zip(charts) {
            if change.iter().all(|c| *c == 0.0) {
                continue;
            }
            let turn = Vector3::new(change[3], change[4], change[5]) / chain.lever;
            let now = log(&(interface.rotation * origin.transpose()));
            interface.rotation = orthonormal(&(exp(&(now + turn)) * origin));
            interface.center += Vector3::new(change[0], change[1], change[2]);
            for (amplitude, change) in interface.warping.iter_mut().zip(&change[POSE..]) {
                *amplitude += change;
            }
        }
    }

    /// Makes `step` and the tension increments the correction Y dT - K⁻¹ r.
    fn correct(
        &mut self,
        chain: &Chain,
        control: &StepTargets,
        state: &TwinState,
        report: &mut StepReport,
    ) -> std::result::Result<(), Cause> {
        let n = chain.n_unknowns();
        self.free_displacement.copy_from_slice(&self.balance.residual);
        self.tangent.solve(&mut self.free_displacement);
        self.solve_tensions(chain, control, state, report)?;
        for (step, free) in self.step[..n].iter_mut().zip(self.free_displacement.as_flattened()) {
            *step = -free;
        }
        self.move_by_tensions(chain);
        Ok(())
    }

    /// Makes an accelerated correction.
    fn accelerate(&mut self, chain: &Chain, control: &StepTargets, state: &mut TwinState) {
        let (n, m) = (chain.n_unknowns(), state.tensions.len());
        if self.n_negative == 0 && self.active_set != self.tensions.qp.active_set() {
            self.active_set.copy_from_slice(self.tensions.qp.active_set());
            self.anderson.clear();
        }
        for j in 0..m {
            self.step[n + j] = self.tensions.increments[j] * self.compliance(j);
        }
        let free = self.free_displacement.as_flattened();
        self.anderson.observe(&self.step, free, &self.tensions.stroke_residual);
        self.anderson.accelerate(&mut self.step);
        for j in 0..m {
            self.tensions.increments[j] = self.step[n + j] / self.compliance(j);
        }
        self.apply(chain, state);
        TensionStep::apply(control, &self.tensions.increments, 1.0, &mut state.tensions);
        self.anderson.moved(&self.step);
    }

    /// Adds the displacement Y dT of the increments to the step.
    fn move_by_tensions(&mut self, chain: &Chain) {
        let n = chain.n_unknowns();
        let moving =
            self.tensions.increments.iter().zip(&self.columns).filter(|(increment, _)| **increment != 0.0);
        for (increment, column) in moving {
            combine_into(chain.isa, &[*increment], &[column.as_flattened()], &mut self.step[..n]);
        }
    }

    fn apply(&mut self, chain: &Chain, state: &mut TwinState) {
        let n = chain.n_unknowns();
        chain.apply(1.0, self.step[..n].as_chunks::<BLOCK>().0, &mut state.interfaces);
    }

    /// The QP for the tension increments, with the free displacement already known.
    fn solve_tensions(
        &mut self,
        chain: &Chain,
        control: &StepTargets,
        state: &TwinState,
        report: &mut StepReport,
    ) -> std::result::Result<(), Cause> {
        let free = &self.free_displacement;
        let missing = |j: usize| self.balance.stroke_residual[j] + row_times(chain, &self.rows, j, free);
        self.tensions.pose(control, &state.tensions, missing);
        if self.n_negative > 0 {
            return self.tensions.solve_taut(&self.delassus, self.n_negative);
        }
        let solver = self.tensions.solve().map_err(Cause::Qp)?;
        report.clarabel_solves += usize::from(solver == QpSolver::Clarabel);
        Ok(())
    }

    /// W_jj [m/N].
    fn compliance(&self, j: usize) -> f64 {
        self.delassus[j * (self.active_set.len() + 1)]
    }

    /// Commits the equilibrium and decides whether the factor is worth keeping.
    fn finish(&mut self, chain: &Chain, state: &TwinState, iterations: usize) {
        self.move_origin(state);
        let (origin, shape, lever) = (&self.origin, &self.balance.shape, chain.lever);
        self.predictor.push(|strokes, point| {
            for (j, stroke) in strokes.iter_mut().enumerate() {
                *stroke = chain.cables.pulled(shape, j, &state.tensions);
            }
            let (charts, tensions) = point.split_at_mut(BLOCK * origin.len());
            let interfaces = state.interfaces[1..].iter().zip(origin);
            for (chart, (interface, origin)) in charts.as_chunks_mut::<BLOCK>().0.iter_mut().zip(interfaces) {
                let turn = lever * log(&(interface.rotation * origin.transpose()));
                chart[..3].copy_from_slice(interface.center.as_slice());
                chart[3..POSE].copy_from_slice(turn.as_slice());
                chart[POSE..].copy_from_slice(&interface.warping);
            }
            tensions.copy_from_slice(&state.tensions);
        });
        self.spent += iterations;
        self.steps += 1;
        self.recent = 0.5 * (self.recent + iterations as f64);
        self.is_unusable = self.recent * self.steps as f64 > REFACTORISATION_COST + self.spent as f64;
    }

    /// Takes the present rotations as the charts' origin where an interface has turned far from it: the history is of the old
    /// one.
    fn move_origin(&mut self, state: &TwinState) {
        let turned = |(interface, origin): (&Interface, &Matrix3<f64>)| {
            log(&(interface.rotation * origin.transpose())).norm() > FAR_TURNED
        };
        if state.interfaces[1..].iter().zip(&self.origin).any(turned) {
            for (origin, interface) in self.origin.iter_mut().zip(&state.interfaces[1..]) {
                *origin = interface.rotation;
            }
            self.predictor.clear();
        }
    }

    /// Newton's method with a new factor in every iteration.
    fn run_newton(
        &mut self,
        (chain, control): (&Chain, &StepTargets),
        state: &mut TwinState,
        report: &mut StepReport,
    ) -> std::result::Result<(), Cause> {
        for (j, tension) in state.tensions.iter_mut().enumerate() {
            *tension = tension.clamp(control.lower[j], control.upper[j]);
        }
        for _ in 0..MAX_NEWTON {
            self.balance.evaluate(chain, control, &state.interfaces, &state.tensions);
            if !self.balance.is_finite() || self.balance.relative > NEWTON_DIVERGED {
                return Err(Cause::Diverged);
            }
            if self.balance.is_met(chain) {
                return Ok(());
            }
            report.newton_iterations += 1;
            self.refactorise(chain, state, report)?;
            self.correct(chain, control, state, report)?;
            self.apply(chain, state);
            TensionStep::apply(control, &self.tensions.increments, 1.0, &mut state.tensions);
        }
        Err(Cause::IterationLimit)
    }

    /// A new factor at `state`.
    fn linearise(&mut self, control: &StepTargets, state: &TwinState) -> std::result::Result<(), Cause> {
        let chain = self.chain.clone();
        self.balance.evaluate(&chain, control, &state.interfaces, &state.tensions);
        self.refactorise(&chain, state, &mut StepReport::default())
    }
}

/// Row j of J times a displacement; its entries are zero beyond the interfaces of the cable.
fn row_times(chain: &Chain, rows: &[Vec<BlockVector>], j: usize, displacement: &[BlockVector]) -> f64 {
    let blocks = chain.reach[j].blocks.clone();
    dot(chain.isa, rows[j][blocks.clone()].as_flattened(), displacement[blocks].as_flattened())
}

impl BodySolver for ChainSolver {
    fn balance(&self) -> Balance<'_> {
        let ChainBalance { shape, stroke_residual, relative, violation, .. } = &self.balance;
        Balance { shape, stroke_residual, relative: *relative, violation: *violation }
    }

    fn evaluate(&mut self, _: &Twin, control: &StepTargets, state: &TwinState) {
        self.balance.evaluate(&self.chain, control, &state.interfaces, &state.tensions);
    }

    fn measure(&mut self, _: &Twin, control: &StepTargets, state: &TwinState) {
        self.balance.settle(&self.chain, &state.interfaces, &state.tensions);
        self.balance.compare_strokes(&self.chain, control, &state.tensions);
    }

    fn reset(&mut self) {
        self.predictor.clear();
        self.anderson.clear();
        self.is_unusable = true;
    }

    fn iterate(
        &mut self,
        _: &Twin,
        control: &StepTargets,
        state: &mut TwinState,
        report: &mut StepReport,
    ) -> std::result::Result<(), Cause> {
        let chain = self.chain.clone();
        self.run((&chain, control), state, report)
    }

    fn newton(
        &mut self,
        _: &Twin,
        control: &StepTargets,
        state: &mut TwinState,
        _: f64,
        report: &mut StepReport,
    ) -> std::result::Result<(), Stuck> {
        let chain = self.chain.clone();
        self.run_newton((&chain, control), state, report)
            .map_err(|cause| Stuck { relative_residual: self.balance.relative, cause })
    }

    fn response(
        &mut self,
        _: &Twin,
        control: &StepTargets,
        state: &TwinState,
        tip: TipMotion,
    ) -> Option<TensionResponse> {
        if self.is_unusable {
            self.linearise(control, state).ok()?;
        }
        Some(self.tension_response(tip))
    }

    fn delassus(&mut self, _: &Twin, control: &StepTargets, state: &TwinState) -> Result<&[f64]> {
        self.linearise(control, state).map_err(|_| singular(self.balance.relative))?;
        Ok(&self.delassus)
    }

    fn tip_derivatives(
        &mut self,
        _: &Twin,
        control: &StepTargets,
        state: &TwinState,
        held: &[usize],
    ) -> Option<TipDerivatives> {
        self.linearise(control, state).ok()?;
        self.derivatives_of_tip(held)
    }

    fn outside(&self) -> f64 {
        self.chain.excess(self.balance.strain)
    }

    fn hint(&self) -> &'static str {
        "reduce the stroke, raise the tension bounds, or leave out the reduced body"
    }
}
