//! External torques by inverse dynamics.
//!
//! τ_ext = M q̈ + C q̇ + g + τ_f − τ_m with q̈ from differences of the speeds through a Butterworth low pass. At the bandwidth of an
//! observer the result goes through r_k = α r_{k−1} + (1 − α) τ_ext,k too, α = 1/(1 + K T): the observers are that filter without the
//! acceleration (Saadatzi et al., 2019, eqs. 19 to 21), so this row is what they must be compared with.

use hysteron_actuator::filter::{LowPass, LowPassState};
use hysteron_actuator::law::Sliding;

use super::{ArmSample, Dynamics, FrictionModel, Observer};

/// Inverse dynamics on filtered accelerations.
#[derive(Debug, Clone)]
pub struct FilteredInverseDynamics<D> {
    dynamics: D,
    friction: FrictionModel,
    smoothing: LowPass,
    /// K of every joint [1/s]; empty where the estimate is not filtered.
    bandwidth: Vec<f64>,
    is_started: bool,
    accelerations: Vec<LowPassState>,
    before: Vec<f64>,
    acceleration: Vec<f64>,
    torque: Vec<f64>,
    estimate: Vec<f64>,
}

impl<D: Dynamics> FilteredInverseDynamics<D> {
    /// Accelerations through `smoothing`, which is designed for the rate of the samples.
    pub fn new(dynamics: D, friction: FrictionModel, smoothing: LowPass) -> Self {
        let n = dynamics.n_joints();
        assert_eq!(n, friction.n_joints());
        let row = || vec![0.0; n];
        Self {
            dynamics,
            friction,
            accelerations: vec![smoothing.start(0.0); n],
            smoothing,
            bandwidth: vec![],
            is_started: false,
            before: row(),
            acceleration: row(),
            torque: row(),
            estimate: row(),
        }
    }

    /// The same with its estimate through a first-order low pass with K of every joint [1/s].
    pub fn at_bandwidth(mut self, gains: &[f64]) -> Self {
        assert_eq!(self.before.len(), gains.len());
        assert!(gains.iter().all(|k| *k > 0.0), "gains {gains:?}");
        self.bandwidth = gains.to_vec();
        self
    }
}

impl<D: Dynamics> Observer for FilteredInverseDynamics<D> {
    fn update(&mut self, sample: &ArmSample, external: &mut [f64]) {
        let is_first = !std::mem::replace(&mut self.is_started, true);
        if is_first {
            self.before.copy_from_slice(sample.velocity);
        }
        for (j, filter) in self.accelerations.iter_mut().enumerate() {
            let difference = (sample.velocity[j] - self.before[j]) / sample.period;
            self.acceleration[j] = filter.next(difference);
            self.before[j] = sample.velocity[j];
        }
        self.dynamics.inverse(sample.position, sample.velocity, &self.acceleration, &mut self.torque);
        for (j, external) in external.iter_mut().enumerate() {
            let (motor, needed) = (sample.torque[j], self.torque[j]);
            let at = Sliding { velocity: sample.velocity[j], motor_torque: motor, load_torque: -needed };
            let input = if is_first {
                0.0
            } else {
                needed + self.friction.follow(j, &at, [motor - needed; 2]) - motor
            };
            let alpha = self.bandwidth.get(j).map_or(0.0, |k| 1.0 / (1.0 + k * sample.period));
            self.estimate[j] = alpha * self.estimate[j] + (1.0 - alpha) * input;
            *external = self.estimate[j];
        }
    }

    fn reset(&mut self) {
        self.is_started = false;
        self.friction.reset();
        self.estimate.fill(0.0);
        self.accelerations.fill(self.smoothing.start(0.0));
    }
}
