//! Rollouts of many trajectories of one model, and their gradients: one trajectory in each lane of a register, registers shared
//! among threads.
//!
//! On the way back only the states after the steps are needed; what is between them is computed again. Every trajectory has its
//! own gradients by the parameters, which are added in the order of the trajectories: the same bytes on any number of threads.

use hysteron_base::lanes::{Isa, LANES, Lanes, Simd, WithSimd};
use rayon::prelude::*;

use crate::batch::Register;
use crate::{ArmStepper, ExternalForce, Integrator, Model, StepGradient};

/// Force and torque, each of three components.
const WRENCH: usize = 6;
/// Inertial parameters of a body.
const INERTIA: usize = 10;

/// Steps trajectories of one model.
#[derive(Debug)]
pub struct ArmRollouts<'m> {
    /// The robot.
    pub model: &'m Model,
    /// How it is advanced.
    pub integrator: Integrator,
    /// Length of a step [s], and its equal parts.
    pub period: (f64, usize),
    /// Steps of a trajectory.
    pub n_steps: usize,
    /// Frames at which external forces act, by their numbers in [`Model::frames`].
    pub frames: Vec<usize>,
    /// Registers to use.
    pub isa: Isa,
}

/// Inputs of the trajectories, one after the other.
#[derive(Debug, Clone, Copy)]
pub struct RolloutInputs<'a> {
    /// q and q̇ at the beginning (trajectories × 2n).
    pub initial: &'a [f64],
    /// Torques (trajectories × steps × n) [N m].
    pub tau: &'a [f64],
    /// Force [N] and torque [N m] in the axes of the base, at every frame (trajectories × steps × frames × 6).
    pub forces: &'a [f64],
    /// Dry friction of all joints [N m], then its growth per torque through their gears [-] as [`ArmStepper::set_friction`] takes them
    /// (trajectories × steps × 2n); empty where friction is the model's.
    pub friction: &'a [f64],
}

/// Gradients of rollouts.
#[derive(Debug, Clone, PartialEq)]
pub struct RolloutGradient {
    /// As [`RolloutInputs::initial`].
    pub initial: Vec<f64>,
    /// As [`RolloutInputs::tau`].
    pub tau: Vec<f64>,
    /// As [`RolloutInputs::forces`].
    pub forces: Vec<f64>,
    /// As [`RolloutInputs::friction`].
    pub friction: Vec<f64>,
    /// By the inertial parameters of all joints, of all trajectories together.
    pub inertias: Vec<[f64; INERTIA]>,
    /// By the armatures.
    pub armature: Vec<f64>,
    /// By the damping.
    pub damping: Vec<f64>,
    /// By the dry friction of the model.
    pub dry_friction: Vec<f64>,
}

/// Numbers of a trajectory.
#[derive(Clone, Copy)]
struct Widths {
    joints: usize,
    state: usize,
    tau: usize,
    forces: usize,
    friction: usize,
    parameters: usize,
}

impl ArmRollouts<'_> {
    fn widths(&self) -> Widths {
        let n = self.model.n_joints();
        Widths {
            joints: n,
            state: 2 * n,
            tau: n * self.n_steps,
            forces: WRENCH * self.frames.len() * self.n_steps,
            friction: 2 * n * self.n_steps,
            parameters: (INERTIA + 3) * n,
        }
    }

    /// Number of trajectories of `inputs`.
    fn check(&self, inputs: &RolloutInputs, states: usize) -> usize {
        let w = self.widths();
        let n = inputs.initial.len() / w.state;
        let found = [inputs.initial.len(), inputs.tau.len(), inputs.forces.len(), states];
        let expected = [w.state, w.tau, w.forces, w.state * self.n_steps].map(|width| width * n);
        assert_eq!(
            found, expected,
            "numbers of initial states, torques, forces and states of {n} trajectories"
        );
        let friction = inputs.friction.len();
        assert!(friction == 0 || friction == w.friction * n, "{friction} of {} frictions", w.friction * n);
        n
    }

    /// q and q̇ after every step into `states` (trajectories × steps × 2n).
    ///
    /// # Panics
    /// Where inputs and states are not of the same trajectories.
    pub fn run(&self, inputs: &RolloutInputs, states: &mut [f64]) {
        self.check(inputs, states.len());
        let width = self.widths().state * self.n_steps;
        states.par_chunks_mut(LANES * width.max(1)).enumerate().for_each(|(part, states)| {
            let rows = LANES * part..LANES * part + states.len() / width;
            self.isa.run(Forward { rollouts: self, inputs: *inputs, rows, states });
        });
    }

    /// Gradients of a loss from those by the states that [`Self::run`] has found, `weights` (trajectories × steps × 2n).
    ///
    /// # Panics
    /// Where inputs, states and weights are not of the same trajectories.
    pub fn pull_back(&self, inputs: &RolloutInputs, states: &[f64], weights: &[f64]) -> RolloutGradient {
        let n = self.check(inputs, states.len());
        assert_eq!(states.len(), weights.len(), "numbers of states and weights");
        let w = self.widths();
        let [mut initial, mut tau, mut forces, mut parameters] =
            [w.state, w.tau, w.forces, w.parameters].map(|width| vec![0.0; width * n]);
        let mut friction = vec![0.0; inputs.friction.len()];
        let parts = initial
            .par_chunks_mut(LANES * w.state)
            .zip(tau.par_chunks_mut((LANES * w.tau).max(1)))
            .zip(parameters.par_chunks_mut(LANES * w.parameters));
        let by_force = shared_out(&mut forces, LANES * w.forces, n.div_ceil(LANES));
        let by_friction = shared_out(&mut friction, LANES * w.friction, n.div_ceil(LANES));
        let parts = parts.zip(by_force).zip(by_friction);
        parts.enumerate().for_each(|(part, ((((initial, tau), parameters), forces), friction))| {
            let rows = LANES * part..LANES * part + initial.len() / w.state;
            let found = RolloutGradients { initial, tau, forces, friction, parameters };
            self.isa.run(Backward { rollouts: self, inputs: *inputs, rows, states, weights, found });
        });
        let mut sum = vec![0.0; w.parameters];
        for one in parameters.chunks(w.parameters) {
            sum.iter_mut().zip(one).for_each(|(sum, part)| *sum += part);
        }
        let (inertias, rest) = sum.split_at(INERTIA * w.joints);
        let (armature, rest) = rest.split_at(w.joints);
        let (damping, dry_friction) = rest.split_at(w.joints);
        let inertias = inertias.chunks(INERTIA).map(|body| std::array::from_fn(|k| body[k])).collect();
        RolloutGradient {
            initial,
            tau,
            forces,
            friction,
            inertias,
            armature: armature.to_vec(),
            damping: damping.to_vec(),
            dry_friction: dry_friction.to_vec(),
        }
    }

    fn stepper<S: Simd>(&self, like: Lanes<S>) -> ArmStepper<Lanes<S>> {
        ArmStepper::new(self.model, self.integrator, self.period, self.frames.len(), like)
    }
}

/// Numbers in `n` parts of `width`; empty parts where there are none.
fn shared_out(numbers: &mut [f64], width: usize, n: usize) -> Vec<&mut [f64]> {
    match numbers.len() {
        0 => (0..n).map(|_| Default::default()).collect(),
        _ => numbers.chunks_mut(width).collect(),
    }
}

/// Torques, friction and external forces of a step, in the lanes of a register.
struct Acting<S: Simd> {
    tau: Vec<Lanes<S>>,
    /// As a step takes it, where it is not the model's.
    friction: Vec<Lanes<S>>,
    external: Vec<ExternalForce<Lanes<S>>>,
}

impl<S: Simd> Acting<S> {
    fn new(rollouts: &ArmRollouts, inputs: &RolloutInputs, zero: Lanes<S>) -> Self {
        let n = rollouts.model.n_joints();
        let external = |frame: &usize| ExternalForce { frame: *frame, force: [zero; 3], torque: [zero; 3] };
        Self {
            tau: vec![zero; n],
            friction: vec![zero; if inputs.friction.is_empty() { 0 } else { 2 * n }],
            external: rollouts.frames.iter().map(external).collect(),
        }
    }

    /// Takes what acts in a step, and gives `stepper` its friction.
    #[inline(always)]
    fn load(
        &mut self,
        (w, inputs): (Widths, &RolloutInputs),
        (register, step): (Register<S>, usize),
        stepper: &mut ArmStepper<Lanes<S>>,
    ) {
        if !self.friction.is_empty() {
            for (k, friction) in self.friction.iter_mut().enumerate() {
                *friction = register.load(inputs.friction, w.friction, 2 * w.joints * step + k);
            }
            let (dry, shares) = self.friction.split_at(w.joints);
            stepper.set_friction([dry, shares]);
        }
        for (k, tau) in self.tau.iter_mut().enumerate() {
            *tau = register.load(inputs.tau, w.tau, w.joints * step + k);
        }
        let start = WRENCH * self.external.len() * step;
        for (k, external) in self.external.iter_mut().enumerate() {
            for c in 0..3 {
                let at = start + WRENCH * k + c;
                external.force[c] = register.load(inputs.forces, w.forces, at);
                external.torque[c] = register.load(inputs.forces, w.forces, at + 3);
            }
        }
    }
}

/// Trajectories `rows`, forwards.
struct Forward<'a> {
    rollouts: &'a ArmRollouts<'a>,
    inputs: RolloutInputs<'a>,
    rows: std::ops::Range<usize>,
    /// Of these trajectories only.
    states: &'a mut [f64],
}

impl WithSimd for Forward<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { rollouts, inputs, rows, states } = self;
        let (w, model) = (rollouts.widths(), rollouts.model);
        let (start, width) = (rows.start, w.state * rollouts.n_steps);
        for register in Register::all(simd, rows) {
            let zero = register.zero();
            let (mut stepper, mut acting, mut tape) =
                (rollouts.stepper(zero), Acting::new(rollouts, &inputs, zero), Vec::new());
            let mut state: Vec<Lanes<S>> =
                (0..w.state).map(|k| register.load(inputs.initial, w.state, k)).collect();
            for step in 0..rollouts.n_steps {
                acting.load((w, &inputs), (register, step), &mut stepper);
                let (q, dq) = state.split_at_mut(w.joints);
                stepper.step(model, [q, dq], &acting.tau, &acting.external, &mut tape);
                tape.clear();
                for (k, value) in state.iter().enumerate() {
                    register.store(*value, states, start, width, w.state * step + k);
                }
            }
        }
    }
}

/// Gradients of some trajectories.
struct RolloutGradients<'a> {
    initial: &'a mut [f64],
    tau: &'a mut [f64],
    forces: &'a mut [f64],
    friction: &'a mut [f64],
    parameters: &'a mut [f64],
}

/// Trajectories `rows`, backwards.
struct Backward<'a> {
    rollouts: &'a ArmRollouts<'a>,
    inputs: RolloutInputs<'a>,
    rows: std::ops::Range<usize>,
    states: &'a [f64],
    weights: &'a [f64],
    /// Of these trajectories only.
    found: RolloutGradients<'a>,
}

impl WithSimd for Backward<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { rollouts, inputs, rows, states, weights, found } = self;
        let (w, model) = (rollouts.widths(), rollouts.model);
        let (start, width) = (rows.start, w.state * rollouts.n_steps);
        for register in Register::all(simd, rows) {
            let zero = register.zero();
            let (mut stepper, mut acting, mut tape) =
                (rollouts.stepper(zero), Acting::new(rollouts, &inputs, zero), Vec::new());
            let mut gradient = StepGradient::new(model, rollouts.frames.len(), zero);
            let [mut before, mut by_state] = [(); 2].map(|()| vec![zero; w.state]);
            for step in (0..rollouts.n_steps).rev() {
                acting.load((w, &inputs), (register, step), &mut stepper);
                for k in 0..w.state {
                    by_state[k] = by_state[k] + register.load(weights, width, w.state * step + k);
                    before[k] = match step {
                        0 => register.load(inputs.initial, w.state, k),
                        _ => register.load(states, width, w.state * (step - 1) + k),
                    };
                }
                let (q, dq) = before.split_at_mut(w.joints);
                stepper.retrace(model, [q, dq], &acting.tau, &acting.external, &mut tape);
                let (q, dq) = by_state.split_at_mut(w.joints);
                stepper.step_back(model, &mut tape, &acting.tau, &acting.external, [q, dq], &mut gradient);
                for (k, value) in gradient.tau.iter().enumerate() {
                    register.store(*value, found.tau, start, w.tau, w.joints * step + k);
                }
                if !acting.friction.is_empty() {
                    let StepGradient { dry_friction, load_friction, .. } = &mut gradient;
                    for (k, sum) in dry_friction.iter_mut().chain(load_friction).enumerate() {
                        // Of this step alone: it is no parameter.
                        let value = std::mem::replace(sum, zero);
                        register.store(value, found.friction, start, w.friction, 2 * w.joints * step + k);
                    }
                }
                let first = WRENCH * rollouts.frames.len() * step;
                for (k, value) in gradient.external.iter().flatten().flatten().enumerate() {
                    register.store(*value, found.forces, start, w.forces, first + k);
                }
            }
            for (k, value) in by_state.iter().enumerate() {
                register.store(*value, found.initial, start, w.state, k);
            }
            let of_joints = gradient.armature.iter().chain(&gradient.damping).chain(&gradient.dry_friction);
            let parameters = gradient.inertias.iter().flatten().chain(of_joints);
            for (k, value) in parameters.enumerate() {
                register.store(*value, found.parameters, start, w.parameters, k);
            }
        }
    }
}
