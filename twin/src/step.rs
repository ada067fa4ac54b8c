//! One quasi-static step: from one equilibrium to the next, x_t = F(x_{t-1}, u_t) (CoReAct paper, eq. 1).

use hysteron_base::BadInput;

use crate::adjoint::{TipAdjoint, tip_adjoints};
use crate::equilibrium_residual::{EquilibriumResidual, StepTargets};
use crate::friction::{bounds_into, change_of_bounds, commit_slip, follow_backlash, stick};
use crate::friction_points::FrictionPoints;
use crate::model::{Target, Twin};
use crate::newton::{Newton, NewtonFailure, StepSearch};
use crate::projection::Projection;
use crate::quasi_newton::QuasiNewton;
use crate::report::StepReport;
use crate::state::TwinState;
use crate::tip::TipResponse;
use crate::{Error, Result};

/// Smallest part of a step that is tried before giving up.
const MIN_STEP_LENGTH: f64 = 1.0 / 4096.0;

/// Largest part of a step that is tried with damping: on a larger one, a smaller one is cheaper.
const MAX_DAMPED_STEP_LENGTH: f64 = 1.0 / 16.0;

/// Change of a friction bound, of the largest, above which a step is made again with the bounds of where it led, and
/// how often at most: a jump then ends with the friction of its end.
pub(crate) const LAGGING: f64 = 0.1;
pub(crate) const MAX_REPEATS: usize = 8;

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
    pub projection: &'a Projection,
    /// Stroke residual of each cable [m]; zero where its tension is prescribed.
    pub stroke_residual: &'a [f64],
    /// Bounds of the tensions [N].
    pub lower: &'a [f64],
    pub upper: &'a [f64],
}

/// Steps a twin from equilibrium to equilibrium. Owns the present equilibrium and all scratch, so that steps allocate
/// nothing in the common case.
///
/// A step commits one value: the state with its friction bounds and prescribed strokes, to which the factor in use and the
/// history belong. [`Stepper::restore`] goes to another equilibrium, and resets both.
#[derive(Debug, Clone)]
pub struct Stepper {
    control: StepTargets,
    balance: EquilibriumResidual,
    quasi_newton: QuasiNewton,
    /// Made when first needed.
    newton: Option<Box<Newton>>,
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
            balance: EquilibriumResidual::new(twin),
            quasi_newton: QuasiNewton::new(twin),
            newton: None,
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

    /// Goes to another equilibrium, where the next step begins.
    ///
    /// # Errors
    /// A state of another twin or with a number that is not finite.
    pub fn restore(&mut self, twin: &Twin, state: &TwinState) -> Result<()> {
        check_state(twin, state)?;
        self.state.clone_from(state);
        self.quasi_newton.reset();
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
        report.relative_residual = self.balance.relative;
        report.stroke_error = self.balance.violation;
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
    ) -> Option<LinearisedStep<'_>> {
        self.restore_friction(memory);
        let state = std::mem::take(&mut self.state);
        self.command(twin, targets, &state);
        self.state = state;
        let (control, state) = (&self.control, &self.state);
        self.balance.evaluate_strokes(twin, control, &state.positions, &state.tensions);
        Some(LinearisedStep {
            state,
            projection: self.quasi_newton.projection(twin, state, &self.balance)?,
            stroke_residual: &self.balance.stroke_residual,
            lower: &control.lower,
            upper: &control.upper,
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
            twin.cables.measure(&state.positions, &mut self.balance.shape);
            bounds_into(twin, &self.balance.shape, &state.tensions, &mut self.bounds);
        }
    }

    /// Makes a step again that has changed the friction bounds a lot, with those of where it led.
    fn follow_friction(&mut self, twin: &Twin, state: &mut TwinState, report: &mut StepReport) {
        for repeat in 0..=MAX_REPEATS {
            bounds_into(twin, &self.balance.shape, &state.tensions, &mut self.bounds);
            if repeat == MAX_REPEATS || change_of_bounds(twin, &self.bounds, &self.control) <= LAGGING {
                break;
            }
            let held = self.control.clone();
            stick(twin, &state.slip, &self.bounds, &mut self.control);
            if !self.step_at_once(twin, state, report) {
                self.control = held;
                self.balance.evaluate(twin, &self.control, &state.positions, &state.tensions);
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
        commit_slip(&twin.cables, &self.control, &self.balance.shape, &state.tensions, &mut state.slip);
    }

    /// The fast iteration, with history and the factor at hand, then without history and with a new factor;
    /// `state` is unchanged where neither leads there.
    fn step_at_once(&mut self, twin: &Twin, state: &mut TwinState, report: &mut StepReport) -> bool {
        if state.load != 1.0 {
            return false;
        }
        self.saved.clone_from(state);
        for _ in 0..2 {
            if self.quasi_newton.run(twin, &self.control, state, &mut self.balance, report).is_ok() {
                return true;
            }
            state.clone_from(&self.saved);
            self.quasi_newton.reset();
        }
        false
    }

    /// Compliance of body and tendons at the present equilibrium, W + C with the Delassus operator W = J K⁻¹ Jᵀ of the exact
    /// tangent in double precision [m/N]: row-major, one row and column per tendon. What friction holds or drags
    /// stays as it is.
    ///
    /// # Errors
    /// The tangent is singular.
    pub fn delassus(&mut self, twin: &Twin) -> Result<Vec<f64>> {
        let state = &self.state;
        self.control.load = state.load;
        self.balance.evaluate(twin, &self.control, &state.positions, &state.tensions);
        self.control.load = 1.0;
        let newton = self.newton.get_or_insert_with(|| Box::new(Newton::new(twin)));
        newton.linearise(twin, state, &self.balance, StepSearch::Full)?;
        let n = twin.tendons.len();
        let rows = newton.projection.delassus.chunks(twin.cables.len().max(1)).take(n);
        Ok(rows.flat_map(|row| &row[..n]).copied().collect())
    }

    /// Displacement of the body per tension at the present equilibrium, the columns of K⁻¹ Jᵀ of the exact tangent [m/N]: one per tendon,
    /// over the unknowns of the free nodes, which come first in model order.
    ///
    /// # Errors
    /// The tangent is singular.
    pub fn displacements_per_tension(&mut self, twin: &Twin) -> Result<Vec<Vec<f64>>> {
        self.delassus(twin)?;
        Ok(self.newton.as_ref().map_or_else(Vec::new, |newton| newton.projection.columns.clone()))
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
        let adjoints = self.tip_adjoints(twin, &held)?;
        let per_force =
            twin.tip_displacements(adjoints.each_ref().map(|adjoint| adjoint.of_force.as_slice()));
        let per_stroke = adjoints.map(|adjoint| {
            let mut all = vec![0.0; twin.n_primary];
            for (value, &j) in adjoint.of_stroke.iter().zip(&held).filter(|(_, j)| **j < twin.n_primary) {
                all[j] = *value;
            }
            all
        });
        Some(TipResponse { per_stroke, per_force })
    }

    /// Derivatives of the tip by all forces and strokes where the last step ended, the cables `held` keeping
    /// their strokes.
    pub(crate) fn tip_adjoints(&mut self, twin: &Twin, held: &[usize]) -> Option<[TipAdjoint; 3]> {
        tip_adjoints(twin, &self.control, &self.state, held, &mut self.quasi_newton)
    }

    #[cfg(test)]
    pub(crate) fn fast_iteration(&mut self) -> &mut QuasiNewton {
        &mut self.quasi_newton
    }

    /// The projection with the lagged factor, computed at the present equilibrium if there is none: approximate.
    pub(crate) fn projection(&mut self, twin: &Twin) -> Option<&Projection> {
        let state = &self.state;
        self.balance.evaluate_strokes(twin, &self.control, &state.positions, &state.tensions);
        self.quasi_newton.projection(twin, state, &self.balance)
    }

    /// Newton's method on parts of the step, halved where it gets stuck.
    fn step_by_parts(&mut self, twin: &Twin, state: &mut TwinState, report: &mut StepReport) -> Result<()> {
        let newton = self.newton.get_or_insert_with(|| Box::new(Newton::new(twin)));
        let mut strokes = twin.pulled(state);
        strokes.extend_from_slice(&self.control.strokes[strokes.len()..]);
        let from = StepTargets {
            strokes,
            lower: state.tensions.clone(),
            upper: state.tensions.clone(),
            load: state.load,
        };
        let (mut reached, mut step_length) = (0.0, 1.0f64);
        let mut control = self.control.clone();
        while reached < 1.0 {
            let next = (reached + step_length).min(1.0);
            control.set_part(&from, &self.control, next);
            self.saved.clone_from(state);
            report.sub_steps += 1;
            let mut outcome = newton.run(twin, &control, state, &mut self.balance, StepSearch::Full, report);
            if outcome.is_err() && step_length <= MAX_DAMPED_STEP_LENGTH {
                state.clone_from(&self.saved);
                outcome = newton.run(twin, &control, state, &mut self.balance, StepSearch::Damped, report);
            }
            match outcome {
                Ok(()) => {
                    state.load = control.load;
                    reached = next;
                    step_length = (2.0 * step_length).min(1.0 - reached);
                }
                Err(NewtonFailure { relative_residual, cause }) => {
                    state.clone_from(&self.saved);
                    step_length *= 0.5;
                    if step_length < MIN_STEP_LENGTH {
                        if reached > 0.0 {
                            let driven = |j: &usize| !self.control.is_tension(*j);
                            for j in (0..self.backlash.len()).filter(driven) {
                                let (a, b) = (from.strokes[j], self.control.strokes[j]);
                                self.backlash[j] = a + reached * (b - a) - twin.tendons[j].zero;
                            }
                        } else {
                            self.backlash.clone_from(&state.backlash);
                        }
                        let hint =
                            "reduce the stroke, raise the tension bounds, or use a finer or quadratic mesh";
                        return Err(Error::NoEquilibrium {
                            reached,
                            relative_residual,
                            cause,
                            hint: hint.into(),
                        });
                    }
                }
            }
        }
        Ok(())
    }
}

fn check_state(twin: &Twin, state: &TwinState) -> Result<()> {
    let found = (state.positions.len(), state.tensions.len(), state.slip.len(), state.backlash.len());
    let expected = (twin.body.n_nodes(), twin.cables.len(), twin.friction.len(), twin.n_backlash());
    if found != expected {
        let text = |(nodes, tensions, slip, backlash): (usize, usize, usize, usize)| {
            format!(
                "{nodes} nodes, {tensions} tensions, {slip} friction points and {backlash} backlash states"
            )
        };
        let (expected, found) = (text(expected), text(found));
        return Err(BadInput::new("state", expected, found).hint("the state is of another robot").into());
    }
    twin.body.check_finite("position", &state.positions)?;
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
