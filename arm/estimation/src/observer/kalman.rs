//! Kalman filter of momentum and external torque.
//!
//! Each joint: ṗ = u + d + w_p, ḋ = w_d, and p is measured with noise; u is the torque that the model explains. The joints are
//! coupled through the momentum itself alone, so each has its own filter of two states.
//!
//! # Reference
//! Wahrburg, Bös, Listmann, Dai, Matthias, Ding (2018), Motor-current-based estimation of Cartesian contact forces and torques
//! for robotic manipulators, section III.

use super::dynamics::TrackedMomentum;
use super::{ArmSample, Dynamics, FrictionModel, Observer};

/// Noise of one joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KalmanNoise {
    /// Standard deviation of the momentum that is measured [N m s].
    pub momentum: f64,
    /// Spectral density (root) of the error of the modelled torque [N m/√Hz].
    pub torque: f64,
    /// Spectral density (root) of the rate of the external torque [N m/s/√Hz].
    pub contact: f64,
}

/// Estimates external torques with their standard deviations.
#[derive(Debug, Clone)]
pub struct KalmanObserver<D> {
    tracked: TrackedMomentum<D>,
    noise: Vec<KalmanNoise>,
    states: Vec<KalmanState>,
    contact: Vec<f64>,
}

#[derive(Debug, Clone, Copy)]
struct KalmanState {
    momentum: f64,
    torque: f64,
    /// Covariance: of p, of p and d, of d.
    covariance: [f64; 3],
}

/// Before the first contact nothing is known of it but its size [N m].
const FIRST_SPREAD: f64 = 1.0;

impl<D: Dynamics> KalmanObserver<D> {
    /// Noise joint by joint; all of it above 0.
    pub fn new(dynamics: D, friction: FrictionModel, noise: &[KalmanNoise]) -> Self {
        assert_eq!(dynamics.n_joints(), noise.len());
        assert!(noise.iter().all(|n| n.momentum > 0.0 && n.torque >= 0.0 && n.contact > 0.0), "{noise:?}");
        let states = noise.iter().map(KalmanState::first).collect();
        let contact = vec![0.0; noise.len()];
        Self { tracked: TrackedMomentum::new(dynamics, friction), noise: noise.to_vec(), states, contact }
    }

    /// Standard deviation of the estimate of `joint` [N m].
    pub fn deviation(&self, joint: usize) -> f64 {
        self.states[joint].covariance[2].sqrt()
    }
}

impl KalmanState {
    fn first(noise: &KalmanNoise) -> Self {
        let covariance = [noise.momentum * noise.momentum, 0.0, FIRST_SPREAD * FIRST_SPREAD];
        Self { momentum: 0.0, torque: 0.0, covariance }
    }

    /// Moves on by `h` under the torque `explained`, then takes the measured momentum. Both exactly.
    fn step(&mut self, noise: &KalmanNoise, h: f64, explained: f64, measured: f64) {
        let [pp, pd, dd] = self.covariance;
        let (by_torque, by_contact) = (noise.torque * noise.torque, noise.contact * noise.contact);
        let pp = pp + h * (2.0 * pd + h * dd) + h * by_torque + h * h * h / 3.0 * by_contact;
        let pd = pd + h * dd + 0.5 * h * h * by_contact;
        let dd = dd + h * by_contact;
        let error = measured - self.momentum - h * (explained + self.torque);
        let total = pp + noise.momentum * noise.momentum;
        let [to_momentum, to_torque] = [pp / total, pd / total];
        self.momentum = measured - (1.0 - to_momentum) * error;
        self.torque += to_torque * error;
        self.covariance = [(1.0 - to_momentum) * pp, (1.0 - to_momentum) * pd, dd - to_torque * pd];
    }
}

impl<D: Dynamics> Observer for KalmanObserver<D> {
    fn update(&mut self, sample: &ArmSample, external: &mut [f64]) {
        let change = self.tracked.advance(sample, &self.contact);
        for (j, (state, noise)) in self.states.iter_mut().zip(&self.noise).enumerate() {
            if change.is_first {
                state.momentum = change.momentum[j];
            } else {
                state.step(noise, sample.period, change.explained[j], change.momentum[j]);
            }
            self.contact[j] = state.torque;
        }
        external.copy_from_slice(&self.contact);
    }

    fn reset(&mut self) {
        self.tracked.reset();
        self.contact.fill(0.0);
        for (state, noise) in self.states.iter_mut().zip(&self.noise) {
            *state = KalmanState::first(noise);
        }
    }
}
