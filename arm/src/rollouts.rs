//! Rollouts of many trajectories of one model, and their gradients: one trajectory in each lane of a register, registers shared
//! among threads.
//!
//! On the way back only the states after the steps are needed; what is between them is computed again. Every trajectory has its
//! own gradients by the parameters, which are added in the order of the trajectories: the same bytes on any number of threads.

use hysteron_base::lanes::{Isa, LANES, Lanes, Simd, WithSimd};
use rayon::prelude::*;

use crate::batch::Register;
use crate::{ExternalForce, Integrator, Model, Scalar, StepGradient, Stepper};

/// Force and torque, each of three components.
const WRENCH: usize = 6;
/// Inertial parameters of a body.
const INERTIA: usize = 10;

/// Steps trajectories of one model.
#[derive(Debug)]
pub struct Rollouts<'m> {
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
    /// Dry friction of the joints per torque through the gear, as [`Stepper::with_load_friction`] takes it.
    pub load_friction: Vec<f64>,
    /// Registers to use.
    pub isa: Isa,
}

/// What drives the trajectories, one after the other.
#[derive(Debug, Clone, Copy)]
pub struct RolloutInputs<'a> {
    /// q and q̇ at the beginning (trajectories × 2n).
    pub initial: &'a [f64],
    /// Torques (trajectories × steps × n) [N m].
    pub tau: &'a [f64],
    /// Force [N] and torque [N m] in the axes of the base, at every frame (trajectories × steps × frames × 6).
    pub forces: &'a [f64],
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
    /// By the inertial parameters of all joints, of all trajectories together.
    pub inertias: Vec<[f64; INERTIA]>,
    /// By the armatures.
    pub armature: Vec<f64>,
    /// By the damping.
    pub damping: Vec<f64>,
    /// By the dry friction.
    pub dry_friction: Vec<f64>,
    /// By the dry friction per torque through the gear.
    pub load_friction: Vec<f64>,
}

/// Numbers of a trajectory.
#[derive(Clone, Copy)]
struct Widths {
    joints: usize,
    state: usize,
    tau: usize,
    forces: usize,
    parameters: usize,
}

impl Rollouts<'_> {
    fn widths(&self) -> Widths {
        let n = self.model.n_joints();
        Widths {
            joints: n,
            state: 2 * n,
            tau: n * self.n_steps,
            forces: WRENCH * self.frames.len() * self.n_steps,
            parameters: (INERTIA + 4) * n,
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
        let parts = initial
            .par_chunks_mut(LANES * w.state)
            .zip(tau.par_chunks_mut((LANES * w.tau).max(1)))
            .zip(parameters.par_chunks_mut(LANES * w.parameters));
        // Without frames there are no forces to share out.
        let by_force: Vec<&mut [f64]> = match w.forces {
            0 => (0..n.div_ceil(LANES)).map(|_| Default::default()).collect(),
            width => forces.chunks_mut(LANES * width).collect(),
        };
        parts.zip(by_force).enumerate().for_each(|(part, (((initial, tau), parameters), forces))| {
            let rows = LANES * part..LANES * part + initial.len() / w.state;
            let found = Found { initial, tau, forces, parameters };
            self.isa.run(Backward { rollouts: self, inputs: *inputs, rows, states, weights, found });
        });
        let mut sum = vec![0.0; w.parameters];
        for one in parameters.chunks(w.parameters) {
            sum.iter_mut().zip(one).for_each(|(sum, part)| *sum += part);
        }
        let (inertias, rest) = sum.split_at(INERTIA * w.joints);
        let (armature, rest) = rest.split_at(w.joints);
        let (damping, rest) = rest.split_at(w.joints);
        let (dry_friction, load_friction) = rest.split_at(w.joints);
        let inertias = inertias.chunks(INERTIA).map(|body| std::array::from_fn(|k| body[k])).collect();
        RolloutGradient {
            initial,
            tau,
            forces,
            inertias,
            armature: armature.to_vec(),
            damping: damping.to_vec(),
            dry_friction: dry_friction.to_vec(),
            load_friction: load_friction.to_vec(),
        }
    }

    fn stepper<S: Simd>(&self, like: Lanes<S>) -> Stepper<Lanes<S>> {
        let shares: Vec<_> = self.load_friction.iter().map(|share| like.splat(*share)).collect();
        Stepper::new(self.model, self.integrator, self.period, self.frames.len(), like)
            .with_load_friction(&shares)
    }
}

/// What acts in a step, in the lanes of a register.
struct Acting<S: Simd> {
    tau: Vec<Lanes<S>>,
    external: Vec<ExternalForce<Lanes<S>>>,
}

impl<S: Simd> Acting<S> {
    fn new(rollouts: &Rollouts, zero: Lanes<S>) -> Self {
        let external = |frame: &usize| ExternalForce { frame: *frame, force: [zero; 3], torque: [zero; 3] };
        Self {
            tau: vec![zero; rollouts.model.n_joints()],
            external: rollouts.frames.iter().map(external).collect(),
        }
    }

    #[inline(always)]
    fn load(&mut self, w: Widths, inputs: &RolloutInputs, register: Register<S>, step: usize) {
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
    rollouts: &'a Rollouts<'a>,
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
                (rollouts.stepper(zero), Acting::new(rollouts, zero), Vec::new());
            let mut state: Vec<Lanes<S>> =
                (0..w.state).map(|k| register.load(inputs.initial, w.state, k)).collect();
            for step in 0..rollouts.n_steps {
                acting.load(w, &inputs, register, step);
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
struct Found<'a> {
    initial: &'a mut [f64],
    tau: &'a mut [f64],
    forces: &'a mut [f64],
    parameters: &'a mut [f64],
}

/// Trajectories `rows`, backwards.
struct Backward<'a> {
    rollouts: &'a Rollouts<'a>,
    inputs: RolloutInputs<'a>,
    rows: std::ops::Range<usize>,
    states: &'a [f64],
    weights: &'a [f64],
    /// Of these trajectories only.
    found: Found<'a>,
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
                (rollouts.stepper(zero), Acting::new(rollouts, zero), Vec::new());
            let mut gradient = StepGradient::new(model, rollouts.frames.len(), zero);
            let [mut before, mut by_state] = [(); 2].map(|()| vec![zero; w.state]);
            for step in (0..rollouts.n_steps).rev() {
                acting.load(w, &inputs, register, step);
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
                let first = WRENCH * rollouts.frames.len() * step;
                for (k, value) in gradient.external.iter().flatten().flatten().enumerate() {
                    register.store(*value, found.forces, start, w.forces, first + k);
                }
            }
            for (k, value) in by_state.iter().enumerate() {
                register.store(*value, found.initial, start, w.state, k);
            }
            let StepGradient { armature, damping, dry_friction, load_friction, .. } = &gradient;
            let of_joints = armature.iter().chain(damping).chain(dry_friction).chain(load_friction);
            let parameters = gradient.inertias.iter().flatten().chain(of_joints);
            for (k, value) in parameters.enumerate() {
                register.store(*value, found.parameters, start, w.parameters, k);
            }
        }
    }
}
