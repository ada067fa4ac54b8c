//! Generalized-momentum observer.
//!
//! r = K (p − p(0) − ∫ (τ_m + Cᵀ q̇ − g − τ_f + r) dt), so that ṙ = K (τ_ext − r). Equations 16 and 21 of Wan et al. (2026) have
//! the integral of the residual with the other sign, and diverge. Here in increments, which is the same and does not grow:
//! r_k = α r_{k−1} + (1 − α) (Δp/T − mean of (τ_m + Cᵀ q̇ − g − τ_f)), with α = 1/(1 + K T) (their eq. 25).

use super::dynamics::TrackedMomentum;
use super::{ArmSample, Dynamics, FrictionModel, Observer};

/// First-order estimate of the external torques, with 1/K as its time constant.
///
/// # Reference
/// De Luca, Mattone (2005), Sensorless robot collision detection and hybrid force/motion control; Wan et al. (2026), eqs. 13 to 25.
#[derive(Debug, Clone)]
pub struct MomentumObserver<D> {
    tracked: TrackedMomentum<D>,
    /// K of every joint [1/s].
    gains: Vec<f64>,
    residual: Vec<f64>,
}

impl<D: Dynamics> MomentumObserver<D> {
    /// `gains` K of every joint [1/s], all above 0.
    pub fn new(dynamics: D, friction: FrictionModel, gains: &[f64]) -> Self {
        assert_eq!(dynamics.n_joints(), gains.len());
        assert!(gains.iter().all(|k| *k > 0.0), "gains {gains:?}");
        let residual = vec![0.0; gains.len()];
        Self { tracked: TrackedMomentum::new(dynamics, friction), gains: gains.to_vec(), residual }
    }

    /// Torque against positive motion that friction of `joint` was taken to have in the last sample [N m].
    pub fn friction(&self, joint: usize) -> f64 {
        self.tracked.friction(joint)
    }
}

impl<D: Dynamics> Observer for MomentumObserver<D> {
    fn update(&mut self, sample: &ArmSample, external: &mut [f64]) {
        let change = self.tracked.advance(sample, &self.residual);
        for ((r, k), unexplained) in self.residual.iter_mut().zip(&self.gains).zip(change.unexplained) {
            let alpha = 1.0 / (1.0 + k * sample.period);
            *r = alpha * *r + (1.0 - alpha) * unexplained;
        }
        external.copy_from_slice(&self.residual);
    }

    fn reset(&mut self) {
        self.residual.fill(0.0);
        self.tracked.reset();
    }
}
