//! Motion, forwards and backwards in time.
//!
//! Semi-implicit Euler with implicit damping: (M + hD) a = τ − D q̇ − C q̇ − g + Jᵀ f, q̇⁺ = q̇ + h a, q⁺ = q + h q̇⁺; damping is then
//! an armature of h D, and one step is one forward dynamics. The way back needs the states only: every step is computed
//! again from its state and pulled back by the adjoint of forward dynamics. Whoever computes torques from states (a
//! controller, a network) does so between the steps, in both directions.

use crate::friction_step::{EndStops, FrictionStep, Substep};
use crate::step_gradient::StepGradient;
use crate::{Cotangent, Data, ExternalForce, Model, Scalar, forward_dynamics, forward_dynamics_adjoint};

/// How velocities and positions are advanced.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Integrator {
    /// First order; stable under damping of any size.
    SemiImplicitEuler,
    /// Fourth order; explicit in everything.
    RungeKutta4,
    /// As semi-implicit Euler, with dry friction that holds exactly, stops, and joints that follow others ([`Simulator`]).
    ///
    /// Gradients are those with the active set fixed: who sticks, slides and stops, and which way.
    ///
    /// [`Simulator`]: crate::Simulator
    WithFriction(EndStops),
}

/// Advances states of one model by a fixed time, and pulls gradients back.
#[derive(Debug, Clone)]
pub struct ArmStepper<T> {
    /// Parameters may be changed through [`ArmStepper::set_parameters`] only: damping is part of the armature here.
    data: Data<T>,
    integrator: Integrator,
    /// Length of a substep [s].
    period: f64,
    substeps: usize,
    damping: Vec<T>,
    /// Without effect unless the integrator has friction.
    dry_friction: Vec<T>,
    /// The same per torque through the gear; empty where it does not grow.
    load_friction: Vec<T>,
    friction: FrictionStep<T>,
    torque: Vec<T>,
    /// q, q̇ and q̈ of up to four stages.
    stages: [[Vec<T>; 3]; 4],
    /// Gradients by q and q̇ of a stage, and their sums over stages.
    back: [Vec<T>; 4],
    cotangent: Cotangent<T>,
}

impl<T: Scalar> ArmStepper<T> {
    /// Steps of `period` [s], each in `substeps` equal parts, of `model` with up to `n_external` external forces, of numbers
    /// like `like`.
    pub fn new(
        model: &Model,
        integrator: Integrator,
        (period, substeps): (f64, usize),
        n_external: usize,
        like: T,
    ) -> Self {
        assert!(period > 0.0 && substeps > 0, "{substeps} substeps of {period} s");
        let row = || vec![like.splat(0.0); model.n_joints()];
        let stops = match integrator {
            Integrator::WithFriction(stops) => stops,
            _ => EndStops::None,
        };
        let mut stepper = Self {
            data: Data::new(model, like),
            integrator,
            period: period / substeps as f64,
            substeps,
            damping: row(),
            dry_friction: row(),
            load_friction: Vec::with_capacity(model.n_joints()),
            friction: FrictionStep::new(model, period / substeps as f64, stops, like),
            torque: row(),
            stages: std::array::from_fn(|_| std::array::from_fn(|_| row())),
            back: std::array::from_fn(|_| row()),
            cotangent: Cotangent::new(model, n_external, like),
        };
        let damping: Vec<T> = model.joints.iter().map(|joint| like.splat(joint.drive.damping)).collect();
        let dry: Vec<T> = model.joints.iter().map(|joint| like.splat(joint.drive.dry_friction)).collect();
        let fresh = Data::new(model, like);
        stepper.set_parameters(&fresh.inertias, &fresh.armature, [&damping, &dry]);
        stepper
    }

    /// Replaces inertias, armatures, dampings and dry frictions of all joints.
    pub fn set_parameters(
        &mut self,
        inertias: &[crate::spatial::Inertia<T>],
        armature: &[T],
        [damping, dry_friction]: [&[T]; 2],
    ) {
        self.data.inertias.copy_from_slice(inertias);
        self.damping.copy_from_slice(damping);
        self.dry_friction.copy_from_slice(dry_friction);
        let implicit = match self.integrator {
            Integrator::SemiImplicitEuler | Integrator::WithFriction(_) => self.period,
            Integrator::RungeKutta4 => 0.0,
        };
        for ((whole, armature), damping) in self.data.armature.iter_mut().zip(armature).zip(damping) {
            *whole = *armature + damping.scale(implicit);
        }
    }

    /// Replaces the dry friction of all joints F and gives them what it grows by per torque through the gear μ (n each, or no μ): a joint
    /// is rubbed by F + μ |τ + b|, b of gravity, Coriolis and outside forces. Without effect unless the integrator has friction.
    #[inline(always)]
    pub fn set_friction(&mut self, [dry, per_torque]: [&[T]; 2]) {
        let n = self.damping.len();
        assert!(per_torque.is_empty() || per_torque.len() == n, "{} of {n} shares", per_torque.len());
        self.dry_friction.copy_from_slice(dry);
        self.load_friction.clear();
        self.load_friction.extend_from_slice(per_torque);
    }

    /// Advances `q`, `dq` by one period under constant torques and external forces. Appends the state before every substep to
    /// `tape`, for [`Self::step_back`].
    #[inline(always)]
    pub fn step(
        &mut self,
        model: &Model,
        [q, dq]: [&mut [T]; 2],
        tau: &[T],
        external: &[ExternalForce<T>],
        tape: &mut Vec<T>,
    ) {
        self.retrace(model, [&mut *q, &mut *dq], tau, external, tape);
        self.substep(model, [q, dq], tau, external);
    }

    /// Appends to `tape` what [`Self::step`] would append, from the state `q`, `dq` before the step, which is left as it is
    /// before the last substep.
    #[inline(always)]
    pub fn retrace(
        &mut self,
        model: &Model,
        [q, dq]: [&mut [T]; 2],
        tau: &[T],
        external: &[ExternalForce<T>],
        tape: &mut Vec<T>,
    ) {
        for s in 0..self.substeps {
            if s > 0 {
                self.substep(model, [&mut *q, &mut *dq], tau, external);
            }
            tape.extend_from_slice(q);
            tape.extend_from_slice(dq);
        }
    }

    /// Advances `q`, `dq` by one substep.
    #[inline(always)]
    fn substep(&mut self, model: &Model, [q, dq]: [&mut [T]; 2], tau: &[T], external: &[ExternalForce<T>]) {
        let like = self.data.like();
        like.apart(
            #[inline(always)]
            || match self.integrator {
                Integrator::SemiImplicitEuler => {
                    self.run_stages(1, model, [&*q, &*dq], tau, external);
                    let acceleration = &self.stages[0][2];
                    for i in 0..q.len() {
                        dq[i] = acceleration[i].mul_add(dq[i].splat(self.period), dq[i]);
                        q[i] = dq[i].mul_add(q[i].splat(self.period), q[i]);
                    }
                }
                Integrator::RungeKutta4 => {
                    self.run_stages(4, model, [&*q, &*dq], tau, external);
                    for ([_, velocity, acceleration], weight) in self.stages.iter().zip([1.0, 2.0, 2.0, 1.0])
                    {
                        let h = weight * self.period / 6.0;
                        add_scaled(q, velocity, h);
                        add_scaled(dq, acceleration, h);
                    }
                }
                Integrator::WithFriction(_) => {
                    let Self { data, damping, dry_friction, load_friction, friction, .. } = self;
                    let at = Substep { model, data, damping, dry_friction, load_friction, tau, external };
                    friction.advance(at, [q, dq]);
                }
            },
        )
    }

    /// States and accelerations of the stages of one substep from `q`, `dq`.
    #[inline(always)]
    fn run_stages(
        &mut self,
        n_stages: usize,
        model: &Model,
        [q, dq]: [&[T]; 2],
        tau: &[T],
        external: &[ExternalForce<T>],
    ) {
        let like = self.data.like();
        like.apart(
            #[inline(always)]
            || {
                for s in 0..n_stages {
                    let (done, rest) = self.stages.split_at_mut(s);
                    let stage = &mut rest[0];
                    stage[0].copy_from_slice(q);
                    stage[1].copy_from_slice(dq);
                    if let Some([_, velocity, acceleration]) = done.last() {
                        let h = if s == 3 { self.period } else { 0.5 * self.period };
                        add_scaled(&mut stage[0], velocity, h);
                        add_scaled(&mut stage[1], acceleration, h);
                    }
                    self.accelerate(model, s, tau, external);
                }
            },
        )
    }

    /// Acceleration of a stage.
    #[inline(always)]
    fn accelerate(&mut self, model: &Model, stage: usize, tau: &[T], external: &[ExternalForce<T>]) {
        let [q, dq, ddq] = &mut self.stages[stage];
        for i in 0..q.len() {
            self.torque[i] = (-self.damping[i]).mul_add(dq[i], tau[i]);
        }
        forward_dynamics(model, &mut self.data, [q, dq, &self.torque], external, ddq);
    }

    /// Pulls the gradient `q`, `dq` by the state after a period back to the state before it, which is taken from the end of
    /// `tape`; with the same torques and external forces as on the way there.
    #[inline(always)]
    pub fn step_back(
        &mut self,
        model: &Model,
        tape: &mut Vec<T>,
        tau: &[T],
        external: &[ExternalForce<T>],
        [q, dq]: [&mut [T]; 2],
        gradient: &mut StepGradient<T>,
    ) {
        let n = q.len();
        let zero = q[0].splat(0.0);
        gradient.tau.fill(zero);
        gradient.external.fill([[zero; 3]; 2]);
        for _ in 0..self.substeps {
            let start = tape.len() - 2 * n;
            let before = [&tape[start..start + n], &tape[start + n..]];
            match self.integrator {
                Integrator::SemiImplicitEuler => {
                    self.run_stages(1, model, before, tau, external);
                    self.euler_back(model, external, [q, dq], gradient);
                }
                Integrator::RungeKutta4 => {
                    self.run_stages(4, model, before, tau, external);
                    self.runge_kutta_back(model, tau, external, [q, dq], gradient);
                }
                Integrator::WithFriction(_) => {
                    let Self { data, damping, dry_friction, load_friction, .. } = self;
                    let [state, velocity, acceleration] = &mut self.stages[0];
                    state.copy_from_slice(before[0]);
                    velocity.copy_from_slice(before[1]);
                    let at = Substep { model, data, damping, dry_friction, load_friction, tau, external };
                    let (state, cotangent) = ([&mut **state, velocity, acceleration], &mut self.cotangent);
                    self.friction.back(at, state, [q, dq], cotangent, gradient);
                }
            }
            tape.truncate(start);
        }
    }

    #[inline(always)]
    fn euler_back(
        &mut self,
        model: &Model,
        external: &[ExternalForce<T>],
        [q, dq]: [&mut [T]; 2],
        gradient: &mut StepGradient<T>,
    ) {
        let h = self.period;
        // The total derivative by q̇⁺; that by the acceleration is h times as large.
        for i in 0..q.len() {
            dq[i] = q[i].scale(h) + dq[i];
            self.torque[i] = dq[i].scale(h);
        }
        self.pull_back(model, 0, external, gradient);
        let [_, velocity, acceleration] = &self.stages[0];
        for i in 0..q.len() {
            let mu = self.cotangent.tau[i];
            q[i] = q[i] + self.cotangent.q[i];
            dq[i] = dq[i] + self.cotangent.dq[i] - self.damping[i] * mu;
            gradient.damping[i] = gradient.damping[i] - mu * (velocity[i] + acceleration[i].scale(h));
        }
    }

    #[inline(always)]
    fn runge_kutta_back(
        &mut self,
        model: &Model,
        tau: &[T],
        external: &[ExternalForce<T>],
        [q, dq]: [&mut [T]; 2],
        gradient: &mut StepGradient<T>,
    ) {
        let (n, h) = (q.len(), self.period);
        let zero = q[0].splat(0.0);
        self.back.iter_mut().for_each(|part| part.fill(zero));
        for (s, (weight, next)) in
            [(1.0, 0.5), (2.0, 0.5), (2.0, 1.0), (1.0, 0.0)].into_iter().enumerate().rev()
        {
            self.accelerate(model, s, tau, external);
            for i in 0..n {
                self.torque[i] = dq[i].scale(weight * h / 6.0) + self.back[1][i].scale(next * h);
            }
            self.pull_back(model, s, external, gradient);
            let [by_q, by_dq, sum_q, sum_dq] = &mut self.back;
            for i in 0..n {
                let mu = self.cotangent.tau[i];
                let by_velocity = q[i].scale(weight * h / 6.0) + by_q[i].scale(next * h);
                by_q[i] = self.cotangent.q[i];
                by_dq[i] = by_velocity + self.cotangent.dq[i] - self.damping[i] * mu;
                gradient.damping[i] = gradient.damping[i] - mu * self.stages[s][1][i];
                sum_q[i] = sum_q[i] + by_q[i];
                sum_dq[i] = sum_dq[i] + by_dq[i];
            }
        }
        for i in 0..n {
            q[i] = q[i] + self.back[2][i];
            dq[i] = dq[i] + self.back[3][i];
        }
    }

    /// Adjoint of the acceleration of `stage`, which was computed last, for the cotangent in `torque`.
    #[inline(always)]
    fn pull_back(
        &mut self,
        model: &Model,
        stage: usize,
        external: &[ExternalForce<T>],
        gradient: &mut StepGradient<T>,
    ) {
        forward_dynamics_adjoint(model, &mut self.data, external, &self.torque, &mut self.cotangent);
        gradient.add(&self.data, &self.stages[stage][2], &mut self.cotangent);
    }
}

/// a += s b.
#[inline(always)]
fn add_scaled<T: Scalar>(a: &mut [T], b: &[T], s: f64) {
    for (a, b) in a.iter_mut().zip(b) {
        *a = b.mul_add(a.splat(s), *a);
    }
}
