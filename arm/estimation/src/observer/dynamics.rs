//! Dynamics of an arm as estimators need them, and the balance of its momentum.

use hysteron_actuator::law::Sliding;

use super::{ArmSample, FrictionModel};

use hysteron_arm_dynamics::{
    Data, Model, bias_torque, generalized_momentum, gravity_torque, inverse_dynamics, mass_matrix,
};

/// Dynamics M q̈ + C q̇ + g of an arm, from a file or learned. All slices have n numbers, one for each joint.
pub trait Dynamics {
    /// Number of joints n.
    fn n_joints(&self) -> usize;

    /// Writes the torques that hold the arm still, g [N m].
    fn gravity(&mut self, q: &[f64], torque: &mut [f64]);

    /// Writes the torques of a motion without acceleration, C q̇ + g [N m].
    fn bias(&mut self, q: &[f64], dq: &[f64], torque: &mut [f64]);

    /// Writes M q̈ + C q̇ + g [N m].
    fn inverse(&mut self, q: &[f64], dq: &[f64], ddq: &[f64], torque: &mut [f64]);

    /// Writes M (n × n, row by row) [kg m²].
    fn mass(&mut self, q: &[f64], mass: &mut [f64]);

    /// Writes p = M q̇ [N m s] and Cᵀ q̇ − g = ½ ∂(q̇ᵀM q̇)/∂q − g [N m].
    fn momentum(&mut self, q: &[f64], dq: &[f64], momentum: &mut [f64], rate: &mut [f64]);
}

/// Dynamics of rigid bodies.
#[derive(Debug, Clone)]
pub struct RigidBody<'m> {
    model: &'m Model,
    /// Scratch; its inertias may be others than the model's.
    pub data: Data<f64>,
}

impl<'m> RigidBody<'m> {
    /// Those of `model`.
    pub fn new(model: &'m Model) -> Self {
        Self { model, data: Data::new(model, 0.0) }
    }
}

impl Dynamics for RigidBody<'_> {
    fn n_joints(&self) -> usize {
        self.model.n_joints()
    }

    fn gravity(&mut self, q: &[f64], torque: &mut [f64]) {
        gravity_torque(self.model, &mut self.data, q, torque);
    }

    fn bias(&mut self, q: &[f64], dq: &[f64], torque: &mut [f64]) {
        bias_torque(self.model, &mut self.data, [q, dq], &[], torque);
    }

    fn inverse(&mut self, q: &[f64], dq: &[f64], ddq: &[f64], torque: &mut [f64]) {
        inverse_dynamics(self.model, &mut self.data, [q, dq, ddq], &[], torque);
    }

    fn mass(&mut self, q: &[f64], mass: &mut [f64]) {
        mass_matrix(self.model, &mut self.data, q, mass);
    }

    fn momentum(&mut self, q: &[f64], dq: &[f64], momentum: &mut [f64], rate: &mut [f64]) {
        generalized_momentum(self.model, &mut self.data, [q, dq], momentum, rate);
    }
}

/// The momentum of an arm from sample to sample, and what of its change is explained.
#[derive(Debug, Clone)]
pub(super) struct TrackedMomentum<D> {
    dynamics: D,
    friction: FrictionModel,
    is_started: bool,
    now: [Vec<f64>; 3],
    before: [Vec<f64>; 3],
    unexplained: Vec<f64>,
    explained: Vec<f64>,
    /// ṗ through a low pass, for the load of the gears.
    slow_change: Vec<f64>,
}

/// Time constant of ṗ in the load that friction sees: from differences of noisy speeds it is mostly noise [s].
const CHANGE_TIME: f64 = 0.02;

/// Change of the momentum since the last sample.
pub(super) struct MomentumChange<'a> {
    /// True for the first sample after a reset.
    pub is_first: bool,
    /// Mean external torque that the change asks for, before any filter [N m].
    pub unexplained: &'a [f64],
    /// Mean of τ_m + Cᵀ q̇ − g − τ_f [N m].
    pub explained: &'a [f64],
    /// Momentum now [N m s].
    pub momentum: &'a [f64],
}

impl<D: Dynamics> TrackedMomentum<D> {
    pub fn new(dynamics: D, friction: FrictionModel) -> Self {
        let n = dynamics.n_joints();
        assert_eq!(n, friction.n_joints(), "joints of the friction model");
        let rows = || [0; 3].map(|_| vec![0.0; n]);
        Self {
            dynamics,
            friction,
            is_started: false,
            now: rows(),
            before: rows(),
            unexplained: vec![0.0; n],
            explained: vec![0.0; n],
            slow_change: vec![0.0; n],
        }
    }

    /// Torque against positive motion that friction was taken to have in the last sample [N m].
    pub fn friction(&self, joint: usize) -> f64 {
        self.friction.last(joint)
    }

    pub fn reset(&mut self) {
        self.is_started = false;
        self.friction.reset();
    }

    /// Takes a sample; the first asks for nothing. `contact` is the present estimate of the external torque, for friction that depends
    /// on load.
    ///
    /// Torques of position and speed count as the mean of both ends (trapezoidal rule).
    pub fn advance(&mut self, sample: &ArmSample, contact: &[f64]) -> MomentumChange<'_> {
        std::mem::swap(&mut self.now, &mut self.before);
        let [momentum, rate, velocity] = &mut self.now;
        self.dynamics.momentum(sample.position, sample.velocity, momentum, rate);
        velocity.copy_from_slice(sample.velocity);
        let is_first = !std::mem::replace(&mut self.is_started, true);
        if is_first {
            self.before.clone_from(&self.now);
        }
        let [momentum, rate, velocity] = &self.now;
        let [old_momentum, old_rate, old_velocity] = &self.before;
        for j in 0..momentum.len() {
            let motor = sample.torque[j];
            let rate = 0.5 * (rate[j] + old_rate[j]);
            let change = (momentum[j] - old_momentum[j]) / sample.period;
            let required = motor + rate - change;
            let share = if is_first { 1.0 } else { sample.period / (CHANGE_TIME + sample.period) };
            self.slow_change[j] += share * (change - self.slow_change[j]);
            let at = Sliding {
                velocity: 0.5 * (velocity[j] + old_velocity[j]),
                motor_torque: motor,
                load_torque: rate - self.slow_change[j] + contact[j],
            };
            let friction = self.friction.follow(j, &at, [required, motor + rate]);
            self.explained[j] = motor + rate - friction;
            self.unexplained[j] = if is_first { 0.0 } else { friction - required };
        }
        MomentumChange {
            is_first,
            unexplained: &self.unexplained,
            explained: &self.explained,
            momentum: &self.now[0],
        }
    }
}
