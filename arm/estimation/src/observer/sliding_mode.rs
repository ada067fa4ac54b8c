//! Sliding-mode momentum observer (super-twisting).
//!
//! With e = p̂ − p: dp̂/dt = u + σ − 1.5 √L |e|^½ sgn e, dσ/dt = −1.1 L sgn e. While the external torque changes by less than L per
//! second, σ is that torque after a finite time, without the lag of a first-order observer; in samples of T it chatters by about L T.
//!
//! # Reference
//! Garofalo, Mansfeld, Jankowski, Ott (2019), Sliding mode momentum observers for estimation of external torques and joint
//! acceleration; gains as in Levant (1998), Robust exact differentiation via sliding mode technique.

use super::dynamics::TrackedMomentum;
use super::{ArmSample, Dynamics, FrictionModel, Observer};

/// Super-twisting estimate of the external torques.
#[derive(Debug, Clone)]
pub struct SlidingModeObserver<D> {
    tracked: TrackedMomentum<D>,
    /// L of every joint [N m/s].
    rates: Vec<f64>,
    momentum: Vec<f64>,
    contact: Vec<f64>,
}

impl<D: Dynamics> SlidingModeObserver<D> {
    /// `rates` L: how fast the external torque of every joint may change [N m/s], above 0.
    pub fn new(dynamics: D, friction: FrictionModel, rates: &[f64]) -> Self {
        let n = dynamics.n_joints();
        assert_eq!(n, rates.len());
        assert!(rates.iter().all(|l| *l > 0.0), "rates {rates:?}");
        let tracked = TrackedMomentum::new(dynamics, friction);
        Self { tracked, rates: rates.to_vec(), momentum: vec![0.0; n], contact: vec![0.0; n] }
    }
}

impl<D: Dynamics> Observer for SlidingModeObserver<D> {
    fn update(&mut self, sample: &ArmSample, external: &mut [f64]) {
        let (h, change) = (sample.period, self.tracked.advance(sample, &self.contact));
        for (j, rate) in self.rates.iter().enumerate() {
            let (model, contact) = (&mut self.momentum[j], &mut self.contact[j]);
            if change.is_first {
                *model = change.momentum[j];
                continue;
            }
            // The error at the sample before; then both ways of it take effect over the step.
            let predicted = *model + h * (change.explained[j] + *contact);
            let error = predicted - change.momentum[j];
            let pull = 1.5 * (rate * error.abs()).sqrt();
            // No further than to the measured momentum: beyond it the step would turn back.
            *model = predicted - (h * pull).min(error.abs()) * error.signum();
            *contact -= h * 1.1 * rate * if error == 0.0 { 0.0 } else { error.signum() };
        }
        external.copy_from_slice(&self.contact);
    }

    fn reset(&mut self) {
        self.tracked.reset();
        self.contact.fill(0.0);
    }
}
