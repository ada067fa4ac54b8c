//! Quasi-static steps of a chain: a lagged factor of the exact tangent, a prediction from the last equilibria, one or two
//! corrections; where that fails, parts of the step with a new factor in every iteration.

use hysteron_fem::vectors::{combine_into, dot};
use hysteron_fit::qp::Activity;
use nalgebra::{Matrix3, Vector3};

use super::balance::ChainBalance;
use super::band::{BlockSkyline, BlockVector};
use super::body::{Chain, ChainState};
use super::rotation::{exp, log, orthonormal};
use super::tangent::TangentAssembly;
use super::{BLOCK, POSE};
use crate::Error;
use crate::anderson::Anderson;
use crate::equilibrium_residual::StepTargets;
use crate::error::Cause;
use crate::friction::{bounds_into, change_of_bounds, commit_slip, follow_backlash, stick};
use crate::model::{Target, Twin};
use crate::predictor::{EquilibriumPredictor, Prescribed};
use crate::report::StepReport;
use crate::step::{LAGGING, MAX_REPEATS, check_targets};
use crate::tensions::TensionStep;

/// Iterations after which a factor is replaced within a step, and after which the step is given up.
const REFACTORISE_AFTER: usize = 4;
const GIVE_UP_AFTER: usize = 24;
/// Growth of the residual over the best one so far that counts as divergence.
const DIVERGED: f64 = 1e3;
/// Smallest part of a step that is tried before giving up.
const MIN_STEP_LENGTH: f64 = 1.0 / 1024.0;
/// Iterations of Newton's method on a part of a step.
const MAX_NEWTON: usize = 12;
/// Residual over the applied forces from which it is given up.
const NEWTON_DIVERGED: f64 = 1e8;
/// Cost of a new factor, in iterations [-].
const REFACTORISATION_COST: f64 = 8.0;
/// Turn of an interface since the charts' origin at which a new origin is taken [rad].
const FAR_TURNED: f64 = 1.5;

/// Steps a chain from equilibrium to equilibrium. Owns the present one and all scratch.
#[derive(Debug, Clone)]
pub struct ChainStepper {
    control: StepTargets,
    state: ChainState,
    saved: ChainState,
    balance: ChainBalance,
    assembly: TangentAssembly,
    tangent: BlockSkyline,
    /// Rows of J when the factor was made [-], and the columns of K⁻¹ Jᵀ [m/N].
    rows: Vec<Vec<BlockVector>>,
    columns: Vec<Vec<BlockVector>>,
    /// W + C, row-major [m/N].
    delassus: Vec<f64>,
    /// Pulls of all cables at the points of a section; scratch.
    pulls: Vec<Vec<f64>>,
    /// Negative eigenvalues of the tangent.
    n_negative: usize,
    /// Friction bounds of the present equilibrium [N], and strokes behind the backlash in this step [m].
    bounds: Vec<f64>,
    backlash: Vec<f64>,
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

impl ChainStepper {
    /// At rest.
    pub fn new(twin: &Twin, chain: &Chain) -> Self {
        let (n, m, isa) = (chain.n_sections(), chain.cables.len(), chain.isa);
        let zeros = vec![[0.0; BLOCK]; n];
        let mut balance = ChainBalance::new(chain);
        balance.place(chain, &chain.rest);
        let mut bounds = vec![0.0; twin.friction.len()];
        bounds_into(twin, &balance.shape, &vec![0.0; m], &mut bounds);
        Self {
            control: StepTargets::new(twin, &vec![Target::Free; twin.tendons.len()]),
            state: chain.rest(),
            saved: chain.rest(),
            balance,
            assembly: TangentAssembly::new(chain),
            tangent: TangentAssembly::pattern(chain),
            rows: vec![zeros.clone(); m],
            columns: vec![zeros.clone(); m],
            delassus: vec![0.0; m * m],
            pulls: Vec::new(),
            n_negative: 0,
            bounds,
            backlash: vec![0.0; twin.n_backlash()],
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

    /// The present equilibrium.
    pub fn state(&self) -> &ChainState {
        &self.state
    }

    /// Goes on to the equilibrium under `targets`, one per tendon.
    ///
    /// # Errors
    /// Targets as [`crate::Stepper::step`] refuses them; [`Error::NoEquilibrium`]: it is then at the last equilibrium before.
    pub fn step(&mut self, twin: &Twin, chain: &Chain, targets: &[Target]) -> Result<StepReport, Error> {
        check_targets(twin, targets)?;
        self.command(twin, targets);
        let mut report = StepReport::default();
        let mut result = Ok(());
        if !self.step_at_once(chain, &mut report) {
            result = self.step_by_parts(chain, &mut report);
        }
        if result.is_ok() {
            self.follow_friction(twin, chain, &mut report);
        } else {
            self.balance.settle(chain, &self.state.interfaces, &self.state.tensions);
            bounds_into(twin, &self.balance.shape, &self.state.tensions, &mut self.bounds);
        }
        self.state.backlash.clone_from(&self.backlash);
        let ChainState { tensions, slip, .. } = &mut self.state;
        commit_slip(&chain.cables, &self.control, &self.balance.shape, tensions, slip);
        report.relative_residual = self.balance.relative;
        report.stroke_error = self.balance.violation;
        report.outside = chain.excess(self.balance.strain);
        result.map(|()| report)
    }

    /// Stroke of tendon `j` at the present equilibrium [m]: geometry alone, without its stretch and zero.
    pub fn stroke(&self, j: usize) -> f64 {
        self.balance.shape.strokes[j]
    }

    /// Length by which tendon `j` has been pulled at its end at the present equilibrium [m].
    pub(super) fn pulled(&self, twin: &Twin, j: usize) -> f64 {
        twin.cables.pulled(&self.balance.shape, j, &self.state.tensions)
    }

    /// Largest strain of a section at the present equilibrium [-], as validations measure it.
    pub fn strain(&self) -> f64 {
        self.balance.strain
    }

    /// Compliance of body and tendons at the present equilibrium, W + C of the exact tangent [m/N]: row-major, one row and
    /// column per tendon. What friction holds or drags stays as it is. To some ten-thousandths where cable points sink into
    /// sections: that this changes with the shape is left out.
    ///
    /// # Errors
    /// The tangent is singular.
    pub fn delassus(&mut self, twin: &Twin, chain: &Chain) -> Result<Vec<f64>, Error> {
        self.linearise(chain)?;
        let n = twin.tendons.len();
        let rows = self.delassus.chunks(chain.cables.len().max(1)).take(n);
        Ok(rows.flat_map(|row| &row[..n]).copied().collect())
    }

    /// Displacement of the recorded tip per tension at the present equilibrium: three rows [m/N], one column per tendon; as
    /// exact as [`Self::delassus`].
    ///
    /// # Errors
    /// The tangent is singular.
    pub fn tip_per_tension(&mut self, twin: &Twin, chain: &Chain) -> Result<[Vec<f64>; 3], Error> {
        self.linearise(chain)?;
        let mut rows = [const { Vec::new() }; 3];
        rows.iter_mut().for_each(|row| row.resize(chain.n_sections(), [0.0; BLOCK]));
        self.assembly.rows_into(chain, &chain.tip, &mut rows);
        let moved: Vec<Vector3<f64>> = self.columns[..twin.tendons.len()]
            .iter()
            .map(|column| {
                let along = |c: usize| dot(chain.isa, rows[c].as_flattened(), column.as_flattened());
                chain.tracker.turn * Vector3::from_fn(|c, _| along(c))
            })
            .collect();
        Ok(std::array::from_fn(|c| moved.iter().map(|moved| moved[c]).collect()))
    }

    /// A new factor at the present equilibrium.
    fn linearise(&mut self, chain: &Chain) -> Result<(), Error> {
        self.evaluate(chain);
        self.refactorise(chain, &mut StepReport::default()).map_err(|cause| Error::NoEquilibrium {
            reached: 1.0,
            relative_residual: self.balance.relative,
            cause,
            hint: "the body can move without force here".into(),
        })
    }

    /// Sets what a step has to reach.
    fn command(&mut self, twin: &Twin, targets: &[Target]) {
        self.control.set(twin, targets);
        self.control.load = 1.0;
        self.backlash.clone_from(&self.state.backlash);
        follow_backlash(twin, targets, &mut self.backlash, &mut self.control);
        stick(twin, &self.state.slip, &self.bounds, &mut self.control);
    }

    /// Makes a step again that has changed the friction bounds a lot, with those of where it led.
    fn follow_friction(&mut self, twin: &Twin, chain: &Chain, report: &mut StepReport) {
        for repeat in 0..=MAX_REPEATS {
            bounds_into(twin, &self.balance.shape, &self.state.tensions, &mut self.bounds);
            if repeat == MAX_REPEATS || change_of_bounds(twin, &self.bounds, &self.control) <= LAGGING {
                break;
            }
            let held = self.control.clone();
            stick(twin, &self.state.slip, &self.bounds, &mut self.control);
            if !self.step_at_once(chain, report) {
                self.control = held;
                self.evaluate(chain);
                break;
            }
        }
    }

    /// The fast iteration, with history and the factor at hand, then with new ones; the state is unchanged where neither leads
    /// to an equilibrium.
    fn step_at_once(&mut self, chain: &Chain, report: &mut StepReport) -> bool {
        if self.state.load != 1.0 {
            return false;
        }
        self.saved.clone_from(&self.state);
        for _ in 0..2 {
            if self.run(chain, report).is_ok() {
                return true;
            }
            self.state.clone_from(&self.saved);
            self.reset();
        }
        false
    }

    /// History and factor no longer fit.
    fn reset(&mut self) {
        self.predictor.clear();
        self.anderson.clear();
        self.is_unusable = true;
    }

    fn run(&mut self, chain: &Chain, report: &mut StepReport) -> Result<(), Cause> {
        if self.is_unusable {
            self.evaluate(chain);
            self.refactorise(chain, report)?;
        }
        self.predict(chain);
        self.anderson.begin();
        let mut best = f64::INFINITY;
        let mut refactorised_at = 0;
        for iteration in 0..GIVE_UP_AFTER {
            self.evaluate(chain);
            if !self.balance.is_finite() || self.balance.relative > DIVERGED * best {
                return Err(Cause::Diverged);
            }
            if self.is_balanced(chain) {
                self.finish(chain, iteration);
                return Ok(());
            }
            best = best.min(self.balance.relative);
            if iteration - refactorised_at == REFACTORISE_AFTER {
                self.refactorise(chain, report)?;
                refactorised_at = iteration;
            }
            report.iterations += 1;
            self.correct(chain, report)?;
            self.accelerate(chain);
        }
        Err(Cause::IterationLimit)
    }

    fn evaluate(&mut self, chain: &Chain) {
        self.balance.evaluate(chain, &self.control, &self.state.interfaces, &self.state.tensions);
    }

    fn is_balanced(&self, chain: &Chain) -> bool {
        self.balance.relative <= chain.accuracy.relative_residual
            && self.balance.violation <= chain.accuracy.stroke
    }

    /// Factor, rows, columns and W at the configuration evaluated last.
    fn refactorise(&mut self, chain: &Chain, report: &mut StepReport) -> Result<(), Cause> {
        report.refactorisations += 1;
        self.is_unusable = true;
        self.assembly.assemble_into(chain, &self.balance, &self.state.tensions, &mut self.tangent);
        self.n_negative = self.tangent.factorize().ok_or(Cause::NoFactor)?;
        let m = self.rows.len();
        for j in 0..m {
            self.balance.row_into(chain, j, &mut self.rows[j]);
            self.columns[j].copy_from_slice(&self.rows[j]);
            self.tangent.solve(&mut self.columns[j]);
            for i in 0..=j {
                let w = dot(chain.isa, self.rows[i].as_flattened(), self.columns[j].as_flattened());
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
    fn predict(&mut self, chain: &Chain) {
        let (n, m) = (chain.n_unknowns(), self.state.tensions.len());
        self.prescribed.clear();
        for j in 0..m {
            self.prescribed.push(match self.active_set[j] {
                Activity::Free if !self.control.is_tension(j) => Prescribed::Stroke(self.control.strokes[j]),
                Activity::AtUpper => Prescribed::Tension(self.control.upper[j], self.compliance(j)),
                _ => Prescribed::Tension(self.control.lower[j], self.compliance(j)),
            });
        }
        self.step.fill(0.0);
        self.predictor.predict(&self.prescribed, &mut self.step);
        self.move_charts(chain);
        self.step[..n].fill(0.0);
        // Prescribed tensions that the history does not explain move the body by Y dT.
        for j in 0..m {
            let expected = self.state.tensions[j] + self.step[n + j];
            self.state.tensions[j] = expected.clamp(self.control.lower[j], self.control.upper[j]);
            self.tensions.increments[j] = self.state.tensions[j] - expected;
        }
        self.move_by_tensions(chain);
        self.apply(chain, 1.0);
        self.balance.settle(chain, &self.state.interfaces, &self.state.tensions);
        self.balance.compare_strokes(chain, &self.control, &self.state.tensions);
        self.free_displacement.fill([0.0; BLOCK]);
        if self.solve_tensions(chain, &mut StepReport::default()).is_ok() {
            self.step.fill(0.0);
            self.move_by_tensions(chain);
            self.apply(chain, 1.0);
            TensionStep::apply(&self.control, &self.tensions.increments, 1.0, &mut self.state.tensions);
        }
    }

    /// Moves the interfaces by a predicted change of their charts.
    fn move_charts(&mut self, chain: &Chain) {
        let charts = self.step.as_chunks::<BLOCK>().0;
        for ((interface, origin), change) in
            self.state.interfaces[1..].iter_mut().zip(&self.origin).zip(charts)
        {
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
    fn correct(&mut self, chain: &Chain, report: &mut StepReport) -> Result<(), Cause> {
        let n = chain.n_unknowns();
        self.free_displacement.copy_from_slice(&self.balance.residual);
        self.tangent.solve(&mut self.free_displacement);
        self.solve_tensions(chain, report)?;
        for (step, free) in self.step[..n].iter_mut().zip(self.free_displacement.as_flattened()) {
            *step = -free;
        }
        self.move_by_tensions(chain);
        Ok(())
    }

    /// Makes an accelerated correction.
    fn accelerate(&mut self, chain: &Chain) {
        let (n, m) = (chain.n_unknowns(), self.state.tensions.len());
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
        self.apply(chain, 1.0);
        TensionStep::apply(&self.control, &self.tensions.increments, 1.0, &mut self.state.tensions);
        self.anderson.moved(&self.step);
    }

    /// Adds the displacement Y dT of the increments to the step.
    fn move_by_tensions(&mut self, chain: &Chain) {
        let n = chain.n_unknowns();
        for (increment, column) in self.tensions.increments.iter().zip(&self.columns) {
            combine_into(chain.isa, &[*increment], &[column.as_flattened()], &mut self.step[..n]);
        }
    }

    fn apply(&mut self, chain: &Chain, factor: f64) {
        let n = chain.n_unknowns();
        chain.apply(factor, self.step[..n].as_chunks::<BLOCK>().0, &mut self.state.interfaces);
    }

    /// The QP for the tension increments, with the free displacement already known.
    fn solve_tensions(&mut self, chain: &Chain, report: &mut StepReport) -> Result<(), Cause> {
        let free = self.free_displacement.as_flattened();
        let missing =
            |j: usize| self.balance.stroke_residual[j] + dot(chain.isa, self.rows[j].as_flattened(), free);
        self.tensions.pose(&self.control, &self.state.tensions, missing);
        if self.n_negative > 0 {
            return self.tensions.solve_taut(&self.delassus, self.n_negative);
        }
        let solver = self.tensions.solve().map_err(Cause::Qp)?;
        report.clarabel_solves += usize::from(solver == hysteron_fit::qp::QpSolver::Clarabel);
        Ok(())
    }

    /// W_jj [m/N].
    fn compliance(&self, j: usize) -> f64 {
        self.delassus[j * (self.active_set.len() + 1)]
    }

    /// Commits the equilibrium and decides whether the factor is worth keeping.
    fn finish(&mut self, chain: &Chain, iterations: usize) {
        self.move_origin();
        let (state, origin, shape, lever) = (&self.state, &self.origin, &self.balance.shape, chain.lever);
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
    fn move_origin(&mut self) {
        let turned = |(interface, origin): (&super::Interface, &Matrix3<f64>)| {
            log(&(interface.rotation * origin.transpose())).norm() > FAR_TURNED
        };
        if self.state.interfaces[1..].iter().zip(&self.origin).any(turned) {
            for (origin, interface) in self.origin.iter_mut().zip(&self.state.interfaces[1..]) {
                *origin = interface.rotation;
            }
            self.predictor.clear();
        }
    }

    /// Newton's method on parts of the step, halved where it fails.
    fn step_by_parts(&mut self, chain: &Chain, report: &mut StepReport) -> Result<(), Error> {
        let asked = self.control.clone();
        self.balance.settle(chain, &self.state.interfaces, &self.state.tensions);
        let mut from = asked.clone();
        from.load = self.state.load;
        let n_tendons = from.strokes.len() - self.bounds.len();
        for j in 0..self.state.tensions.len() {
            if j >= n_tendons {
                continue;
            }
            from.strokes[j] = chain.cables.pulled(&self.balance.shape, j, &self.state.tensions);
            (from.lower[j], from.upper[j]) = (self.state.tensions[j], self.state.tensions[j]);
        }
        let (mut reached, mut step_length) = (0.0, 1.0f64);
        while reached < 1.0 {
            let next = (reached + step_length).min(1.0);
            self.control.set_part(&from, &asked, next);
            self.saved.clone_from(&self.state);
            report.sub_steps += 1;
            match self.newton(chain, report) {
                Ok(()) => {
                    self.state.load = self.control.load;
                    reached = next;
                    step_length = (2.0 * step_length).min(1.0 - reached);
                }
                Err(cause) => {
                    let relative_residual = self.balance.relative;
                    self.state.clone_from(&self.saved);
                    step_length *= 0.5;
                    if step_length < MIN_STEP_LENGTH {
                        self.reset();
                        let hint = "reduce the stroke or raise the tension bounds".into();
                        return Err(Error::NoEquilibrium { reached, relative_residual, cause, hint });
                    }
                }
            }
        }
        self.predictor.clear();
        self.finish(chain, 0);
        Ok(())
    }

    /// Newton's method with a new factor in every iteration.
    fn newton(&mut self, chain: &Chain, report: &mut StepReport) -> Result<(), Cause> {
        for j in 0..self.state.tensions.len() {
            let (lower, upper) = (self.control.lower[j], self.control.upper[j]);
            self.state.tensions[j] = self.state.tensions[j].clamp(lower, upper);
        }
        for _ in 0..MAX_NEWTON {
            self.evaluate(chain);
            if !self.balance.is_finite() || self.balance.relative > NEWTON_DIVERGED {
                return Err(Cause::Diverged);
            }
            if self.is_balanced(chain) {
                return Ok(());
            }
            report.newton_iterations += 1;
            self.refactorise(chain, report)?;
            self.correct(chain, report)?;
            self.apply(chain, 1.0);
            TensionStep::apply(&self.control, &self.tensions.increments, 1.0, &mut self.state.tensions);
        }
        Err(Cause::IterationLimit)
    }
}
