//! One quasi-static step: from one equilibrium to the next, x_t = F(x_{t-1}, u_t) (CoReAct paper, eq. 1).

use hysteron_base::BadInput;

use crate::chain::{ChainSolver, Interface};
use crate::equilibrium_residual::StepTargets;
use crate::friction::{bounds_into, change_of_bounds, commit_slip, follow_backlash, stick};
use crate::friction_points::FrictionPoints;
use crate::mesh_solver::MeshSolver;
use crate::model::{Target, Twin};
use crate::report::StepReport;
use crate::solver::{BodySolver, Stuck, TensionResponse, TipDerivatives, TipMotion};
use crate::state::TwinState;
use crate::tip::TipResponse;
use crate::{Error, Result};

/// Smallest part of a step that is tried before giving up.
const MIN_STEP_LENGTH: f64 = 1.0 / 4096.0;

/// Change of a friction bound, of the largest, above which a step is made again with the bounds of where it led, and
/// how often at most: a jump then ends with the friction of its end.
const LAGGING: f64 = 0.1;
const MAX_REPEATS: usize = 8;

/// Slip and backlash state of an equilibrium with its friction bounds: one value that a step is made from, several times where
/// it has to be, and that a step commits.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct FrictionMemory {
    slip: Vec<f64>,
    backlash: Vec<f64>,
    /// Friction bounds [N].
    bounds: Vec<f64>,
}

/// Residual of a step, linearised at a state.
#[derive(Debug)]
pub(crate) struct LinearisedStep<'a> {
    /// The state.
    pub state: &'a TwinState,
    /// With the lagged factor: approximate.
    pub response: TensionResponse,
    /// Stroke residual of each cable [m]; zero where its tension is prescribed.
    pub stroke_residual: &'a [f64],
    /// Bounds of the tensions [N].
    pub lower: &'a [f64],
    pub upper: &'a [f64],
}

/// The solver of a twin's body.
#[derive(Debug, Clone)]
enum TwinSolver {
    Mesh(Box<MeshSolver>),
    Chain(Box<ChainSolver>),
}

impl TwinSolver {
    fn new(twin: &Twin) -> Self {
        match &twin.chain {
            Some(chain) => Self::Chain(Box::new(ChainSolver::new(chain))),
            None => Self::Mesh(Box::new(MeshSolver::new(twin))),
        }
    }

    fn get(&self) -> &dyn BodySolver {
        match self {
            Self::Mesh(solver) => &**solver,
            Self::Chain(solver) => &**solver,
        }
    }

    fn get_mut(&mut self) -> &mut dyn BodySolver {
        match self {
            Self::Mesh(solver) => &mut **solver,
            Self::Chain(solver) => &mut **solver,
        }
    }
}

/// Steps a twin from equilibrium to equilibrium. Owns the present equilibrium and all scratch, so that steps allocate
/// nothing in the common case.
///
/// A step commits one value: the state with its friction bounds and prescribed strokes, to which the factor in use and the
/// history belong. [`Stepper::restore`] goes to another equilibrium, and resets both.
#[derive(Debug, Clone)]
pub struct Stepper {
    control: StepTargets,
    solver: TwinSolver,
    /// The last equilibrium on the way, to return to.
    saved: TwinState,
    /// The equilibrium that is committed.
    state: TwinState,
    /// Its friction bounds [N].
    bounds: Vec<f64>,
    /// Strokes behind the backlash in this step [m].
    backlash: Vec<f64>,
}

impl Stepper {
    /// Scratch for steps of `twin`.
    pub fn new(twin: &Twin) -> Self {
        let mut stepper = Self {
            control: StepTargets::new(twin, &vec![Target::Free; twin.tendons.len()]),
            solver: TwinSolver::new(twin),
            saved: twin.rest(),
            state: twin.rest(),
            bounds: vec![0.0; twin.friction.len()],
            backlash: vec![0.0; twin.n_backlash()],
        };
        stepper.measure_friction(twin, &twin.rest());
        stepper
    }

    /// The present equilibrium; rest before the first step.
    pub fn state(&self) -> &TwinState {
        &self.state
    }

    /// The stroke that a servo shows for every tendon at the present equilibrium [m], as [`Twin::commands_of`].
    pub fn commands(&mut self, twin: &Twin) -> Vec<f64> {
        self.solver.get_mut().measure(twin, &self.control, &self.state);
        let shape = self.solver.get().balance().shape;
        let command = |j: usize| twin.cables.pulled(shape, j, &self.state.tensions) - twin.tendons[j].zero;
        (0..twin.tendons.len()).map(command).collect()
    }

    /// Goes to another equilibrium, where the next step begins.
    ///
    /// # Errors
    /// A state of another twin or with a number that is not finite.
    pub fn restore(&mut self, twin: &Twin, state: &TwinState) -> Result<()> {
        check_state(twin, state)?;
        self.state.clone_from(state);
        self.solver.get_mut().reset();
        self.measure_friction(twin, state);
        Ok(())
    }

    /// Goes on to the equilibrium under `targets` (one per tendon).
    ///
    /// # Errors
    /// A wrong number of targets, one that is not finite, a stroke longer than its tendon, or a tension
    /// out of its bounds; [`Error::NoEquilibrium`]: it is then at the last equilibrium before.
    pub fn step(&mut self, twin: &Twin, targets: &[Target]) -> Result<StepReport> {
        check_targets(twin, targets)?;
        let mut state = std::mem::take(&mut self.state);
        let result = self.step_from(twin, targets, &mut state);
        self.state = state;
        result
    }

    fn step_from(&mut self, twin: &Twin, targets: &[Target], state: &mut TwinState) -> Result<StepReport> {
        let mut report = StepReport::default();
        self.command(twin, targets, state);
        let mut result = Ok(());
        if !self.step_at_once(twin, state, &mut report) {
            result = self.step_by_parts(twin, state, &mut report);
        }
        if result.is_ok() {
            self.follow_friction(twin, state, &mut report);
        }
        let balance = self.solver.get().balance();
        report.relative_residual = balance.relative;
        report.stroke_error = balance.violation;
        report.outside = self.solver.get().outside();
        self.commit(twin, &result, state);
        result.map(|()| report)
    }

    /// The last step once more, with other targets: from where it led, with the friction memory from before it.
    ///
    /// # Errors
    /// Those of [`Self::step`].
    pub(crate) fn step_again(
        &mut self,
        twin: &Twin,
        targets: &[Target],
        memory: &FrictionMemory,
    ) -> Result<StepReport> {
        self.restore_friction(memory);
        self.step(twin, targets)
    }

    /// Linearised residual of a step from `memory` at the present state; `None` without a stiffness.
    pub(crate) fn conditions(
        &mut self,
        twin: &Twin,
        targets: &[Target],
        memory: &FrictionMemory,
        tip: TipMotion,
    ) -> Option<LinearisedStep<'_>> {
        self.restore_friction(memory);
        let state = std::mem::take(&mut self.state);
        self.command(twin, targets, &state);
        self.state = state;
        let response = self.response(twin, tip)?;
        Some(LinearisedStep {
            state: &self.state,
            response,
            stroke_residual: self.solver.get().balance().stroke_residual,
            lower: &self.control.lower,
            upper: &self.control.upper,
        })
    }

    /// The friction memory of the present equilibrium.
    pub(crate) fn memory_into(&self, memory: &mut FrictionMemory) {
        memory.slip.clone_from(&self.state.slip);
        memory.backlash.clone_from(&self.state.backlash);
        memory.bounds.clone_from(&self.bounds);
    }

    /// Replaces the friction memory of the present equilibrium; history and factor stay.
    fn restore_friction(&mut self, memory: &FrictionMemory) {
        self.state.slip.clone_from(&memory.slip);
        self.state.backlash.clone_from(&memory.backlash);
        self.bounds.clone_from(&memory.bounds);
    }

    /// True where the last step left cable `j` with a tension between its bounds: its stroke is held.
    pub(crate) fn is_held(&self, j: usize) -> bool {
        let tension = self.state.tensions[j];
        tension > self.control.lower[j] && tension < self.control.upper[j]
    }

    /// Sets what a step from `state` has to reach.
    fn command(&mut self, twin: &Twin, targets: &[Target], state: &TwinState) {
        self.control.set(twin, targets);
        self.backlash.clone_from(&state.backlash);
        follow_backlash(twin, targets, &mut self.backlash, &mut self.control);
        stick(twin, &state.slip, &self.bounds, &mut self.control);
    }

    /// Friction bounds of the equilibrium `state`.
    fn measure_friction(&mut self, twin: &Twin, state: &TwinState) {
        if !twin.friction.is_empty() {
            self.solver.get_mut().measure(twin, &self.control, state);
            bounds_into(twin, self.solver.get().balance().shape, &state.tensions, &mut self.bounds);
        }
    }

    /// Makes a step again that has changed the friction bounds a lot, with those of where it led.
    fn follow_friction(&mut self, twin: &Twin, state: &mut TwinState, report: &mut StepReport) {
        for repeat in 0..=MAX_REPEATS {
            bounds_into(twin, self.solver.get().balance().shape, &state.tensions, &mut self.bounds);
            if repeat == MAX_REPEATS || change_of_bounds(twin, &self.bounds, &self.control) <= LAGGING {
                break;
            }
            let held = self.control.clone();
            stick(twin, &state.slip, &self.bounds, &mut self.control);
            if !self.step_at_once(twin, state, report) {
                self.control = held;
                self.solver.get_mut().evaluate(twin, &self.control, state);
                break;
            }
        }
    }

    /// Moves the memory of friction and backlash to the equilibrium `state`, at the end of a step or on the way where
    /// `result` is a failure.
    fn commit(&mut self, twin: &Twin, result: &Result<()>, state: &mut TwinState) {
        if result.is_err() {
            self.measure_friction(twin, state);
        }
        state.backlash.clone_from(&self.backlash);
        let shape = self.solver.get().balance().shape;
        commit_slip(&twin.cables, &self.control, shape, &state.tensions, &mut state.slip);
    }

    /// The fast iteration, with the factor and history at hand, then without history and with a new factor;
    /// `state` is unchanged where neither leads there.
    fn step_at_once(&mut self, twin: &Twin, state: &mut TwinState, report: &mut StepReport) -> bool {
        if state.load != 1.0 {
            return false;
        }
        self.saved.clone_from(state);
        for _ in 0..2 {
            if self.solver.get_mut().iterate(twin, &self.control, state, report).is_ok() {
                return true;
            }
            state.clone_from(&self.saved);
            self.solver.get_mut().reset();
        }
        false
    }

    /// Compliance of body and tendons at the present equilibrium, W + C with the Delassus operator W = J K⁻¹ Jᵀ of the exact
    /// tangent in double precision [m/N]: row-major, one row and column per tendon. What friction holds or drags
    /// stays as it is. Of a chain to some ten-thousandths where cable points sink into sections: that this changes with the
    /// shape is left out.
    ///
    /// # Errors
    /// The tangent is singular.
    pub fn delassus(&mut self, twin: &Twin) -> Result<Vec<f64>> {
        self.control.load = self.state.load;
        let found = self.solver.get_mut().delassus(twin, &self.control, &self.state);
        self.control.load = 1.0;
        let n = twin.tendons.len();
        let rows = found?.chunks(twin.cables.len().max(1)).take(n);
        Ok(rows.flat_map(|row| &row[..n]).copied().collect())
    }

    /// Displacement of the finite elements per tension at the present equilibrium, the columns of K⁻¹ Jᵀ of the exact tangent
    /// [m/N]: one per tendon, over the unknowns of the free nodes, which come first in model order.
    ///
    /// # Errors
    /// The tangent is singular; a chain, which has no nodes.
    pub fn displacements_per_tension(&mut self, twin: &Twin) -> Result<Vec<Vec<f64>>> {
        let TwinSolver::Mesh(solver) = &mut self.solver else {
            return Err(BadInput::new("body", "finite elements", "a chain of sections")
                .hint("leave out the reduced body")
                .into());
        };
        self.control.load = self.state.load;
        let columns = solver.columns(twin, &self.control, &self.state).map(<[Vec<f64>]>::to_vec);
        self.control.load = 1.0;
        columns
    }

    /// Response of the tip to small changes where the last step ended; auxiliary tendons keep their tensions.
    /// Of the exact tangent, to a tenth of a per cent.
    ///
    /// `None` where the body has no stiffness or two tendons pull the same way.
    pub fn tip_response(&mut self, twin: &Twin, friction: FrictionPoints) -> Option<TipResponse> {
        let n_counted = match friction {
            FrictionPoints::AsTheyAre => self.state.tensions.len(),
            FrictionPoints::Slipping => twin.tendons.len(),
        };
        let held: Vec<usize> = (0..n_counted).filter(|&j| self.is_held(j)).collect();
        let TipDerivatives { per_stroke, per_force, .. } = self.tip_derivatives(twin, &held)?;
        let per_stroke = per_stroke.map(|of_held| {
            let mut all = vec![0.0; twin.n_primary];
            for (value, &j) in of_held.iter().zip(&held).filter(|(_, j)| **j < twin.n_primary) {
                all[j] = *value;
            }
            all
        });
        Some(TipResponse { per_stroke, per_force })
    }

    /// Derivatives of the tip where the last step ended, the cables `held` keeping their strokes.
    pub(crate) fn tip_derivatives(&mut self, twin: &Twin, held: &[usize]) -> Option<TipDerivatives> {
        self.solver.get_mut().tip_derivatives(twin, &self.control, &self.state, held)
    }

    /// Response to tensions with the lagged factor, computed at the present equilibrium if there is none: approximate.
    pub(crate) fn response(&mut self, twin: &Twin, tip: TipMotion) -> Option<TensionResponse> {
        let solver = self.solver.get_mut();
        solver.measure(twin, &self.control, &self.state);
        solver.response(twin, &self.control, &self.state, tip)
    }

    /// The iteration of finite elements.
    #[cfg(test)]
    pub(crate) fn fast_iteration(&mut self) -> &mut crate::quasi_newton::QuasiNewton {
        match &mut self.solver {
            TwinSolver::Mesh(solver) => &mut solver.quasi_newton,
            TwinSolver::Chain(_) => unreachable!("a chain"),
        }
    }

    /// Newton's method on parts of the step, halved where it gets stuck.
    fn step_by_parts(&mut self, twin: &Twin, state: &mut TwinState, report: &mut StepReport) -> Result<()> {
        let from = self.present_targets(twin, state);
        let (mut reached, mut step_length) = (0.0, 1.0f64);
        let mut control = self.control.clone();
        while reached < 1.0 {
            let next = (reached + step_length).min(1.0);
            control.set_part(&from, &self.control, next);
            self.saved.clone_from(state);
            report.sub_steps += 1;
            match self.solver.get_mut().newton(twin, &control, state, step_length, report) {
                Ok(()) => {
                    state.load = control.load;
                    reached = next;
                    step_length = (2.0 * step_length).min(1.0 - reached);
                }
                Err(Stuck { relative_residual, cause }) => {
                    state.clone_from(&self.saved);
                    step_length *= 0.5;
                    if step_length < MIN_STEP_LENGTH {
                        self.leave_backlash(twin, state, &from, reached);
                        let hint = self.solver.get().hint().into();
                        return Err(Error::NoEquilibrium { reached, relative_residual, cause, hint });
                    }
                }
            }
        }
        Ok(())
    }

    /// Targets that the equilibrium `state` meets.
    fn present_targets(&mut self, twin: &Twin, state: &TwinState) -> StepTargets {
        self.solver.get_mut().measure(twin, &self.control, state);
        let shape = self.solver.get().balance().shape;
        let pulled = |j: usize| twin.cables.pulled(shape, j, &state.tensions);
        let mut strokes: Vec<f64> = (0..twin.tendons.len()).map(pulled).collect();
        strokes.extend_from_slice(&self.control.strokes[strokes.len()..]);
        StepTargets {
            strokes,
            lower: state.tensions.clone(),
            upper: state.tensions.clone(),
            load: state.load,
        }
    }

    /// Leaves the backlash where a part of the step has brought it.
    fn leave_backlash(&mut self, twin: &Twin, state: &TwinState, from: &StepTargets, reached: f64) {
        if reached == 0.0 {
            self.backlash.clone_from(&state.backlash);
            return;
        }
        let driven = |j: &usize| !self.control.is_tension(*j);
        for j in (0..self.backlash.len()).filter(driven) {
            let (a, b) = (from.strokes[j], self.control.strokes[j]);
            self.backlash[j] = a + reached * (b - a) - twin.tendons[j].zero;
        }
    }
}

fn check_state(twin: &Twin, state: &TwinState) -> Result<()> {
    let found = ([state.positions.len(), state.interfaces.len()], state.tensions.len());
    let found = (found, state.slip.len(), state.backlash.len());
    let expected = ((twin.configuration(), twin.cables.len()), twin.friction.len(), twin.n_backlash());
    if found != expected {
        let text = |(([nodes, interfaces], tensions), slip, backlash): (
            ([usize; 2], usize),
            usize,
            usize,
        )| {
            let configuration = match interfaces {
                0 => format!("{nodes} nodes"),
                _ => format!("{interfaces} interfaces"),
            };
            format!(
                "{configuration}, {tensions} tensions, {slip} friction points and {backlash} backlash states"
            )
        };
        let (expected, found) = (text(expected), text(found));
        return Err(BadInput::new("state", expected, found).hint("the state is of another robot").into());
    }
    twin.body.check_finite("position", &state.positions)?;
    let is_finite = |interface: &Interface| {
        let Interface { center, rotation, warping } = interface;
        center.iter().chain(rotation).chain(warping).all(|number| number.is_finite())
    };
    if let Some(i) = state.interfaces.iter().position(|interface| !is_finite(interface)) {
        return Err(BadInput::new(format!("state: interface {i}"), "finite numbers", "others").into());
    }
    if let Some(j) = state.tensions.iter().position(|tension| !tension.is_finite()) {
        let place = match twin.tendons.get(j) {
            Some(tendon) => format!("state: tension of tendon {}", tendon.name),
            None => format!("state: jump at friction point {}", j - twin.tendons.len() + 1),
        };
        return Err(BadInput::new(place, "a finite number", state.tensions[j].to_string()).into());
    }
    if let Some(number) = state.slip.iter().chain(&state.backlash).find(|number| !number.is_finite()) {
        let place = "state: memory of friction and backlash";
        return Err(BadInput::new(place, "finite numbers", number.to_string()).into());
    }
    if !(0.0..=1.0).contains(&state.load) {
        return Err(BadInput::new("state: load", "0 to 1", state.load.to_string()).into());
    }
    Ok(())
}

pub(crate) fn check_targets(twin: &Twin, targets: &[Target]) -> Result<()> {
    if targets.len() != twin.tendons.len() {
        let expected = format!("{} targets, one per tendon", twin.tendons.len());
        return Err(BadInput::new("targets", expected, targets.len().to_string()).into());
    }
    for (j, target) in targets.iter().enumerate() {
        let tendon = &twin.tendons[j].name;
        let length = twin.cables.rest_lengths[j];
        match *target {
            Target::Stroke(stroke) if !(stroke.is_finite() && stroke + twin.tendons[j].zero < length) => {
                let expected = format!("less than the tendon's length, {:.3} mm", 1e3 * length);
                return Err(BadInput::new(
                    format!("stroke of tendon {tendon}"),
                    expected,
                    format!("{:.3} mm", 1e3 * stroke),
                )
                .hint("strokes are in metres in memory; check the column's unit suffix")
                .into());
            }
            Target::Tension(tension) if !twin.tendons[j].tension.contains(tension) => {
                let bounds = twin.tendons[j].tension;
                return Err(BadInput::new(
                    format!("tension of tendon {tendon}"),
                    format!("{} to {} N", bounds.min, bounds.max),
                    format!("{tension} N"),
                )
                .hint("the tendon's bounds are part of the scene")
                .into());
            }
            _ => {}
        }
    }
    Ok(())
}
