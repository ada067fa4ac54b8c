//! External joint torques from motion and motor torques, without a sensor of force.
//!
//! M q̈ + C q̇ + g + τ_f = τ_m + τ_ext: an external torque counts as positive where it pushes towards positive coordinates, as
//! the motor's does. (In Wan et al. (2026) and De Luca, Mattone (2005) signs of τ_ext differ.) Every estimator is an
//! [`Observer`]: one sample at a time, no allocation; [`estimate`] runs one over recorded rows. The equations are in
//! `docs/observers.md`.

mod balance;
mod disturbance;
mod drive;
mod dynamics;
mod force_filter;
mod friction;
mod inverse;
mod kalman;
mod momentum;
mod sliding_mode;
mod tip_force;

pub use balance::{StaticResidual, Terms};
pub use disturbance::{DisturbanceObserver, ObserverGain};
pub use drive::{DriveReading, MotorTorque};
pub use dynamics::{Dynamics, RigidBody};
pub use force_filter::ForceFilter;
pub use friction::{FrictionModel, LowSpeed};
pub use inverse::FilteredInverseDynamics;
pub use kalman::{KalmanNoise, KalmanObserver};
pub use momentum::MomentumObserver;
pub use sliding_mode::SlidingModeObserver;
pub use tip_force::{ContactPrior, TipForceEstimator};

/// An arm at one instant, n numbers each.
#[derive(Debug, Clone, Copy)]
pub struct ArmSample<'a> {
    /// Time since the last sample, above 0 [s].
    pub period: f64,
    /// Coordinates now [rad] or [m].
    pub position: &'a [f64],
    /// Speeds now [rad/s] or [m/s].
    pub velocity: &'a [f64],
    /// Torques of the motors at the joints since the last sample: their mean, or the command that was held [N m] or [N].
    pub torque: &'a [f64],
}

/// Estimates the external torques of an arm from one sample after the other.
pub trait Observer {
    /// Takes a sample and writes the external torques (n) [N m]. Allocates nothing.
    ///
    /// The first sample after [`Self::reset`] sets the initial state; an estimator with memory gives zeros for it.
    fn update(&mut self, sample: &ArmSample, external: &mut [f64]);

    /// Forgets all samples.
    fn reset(&mut self);
}

/// Runs `observer` from its reset over rows of samples; gives its external torques, row by row (n_samples × n) [N m].
///
/// `periods` has the time before every row [s]; the others are row by row (n_samples × n), as in [`ArmSample`].
pub fn estimate(
    observer: &mut (impl Observer + ?Sized),
    periods: &[f64],
    [position, velocity, torque]: [&[f64]; 3],
) -> Vec<f64> {
    let n = position.len() / periods.len().max(1);
    let mut external = vec![0.0; position.len()];
    observer.reset();
    for (s, (period, external)) in periods.iter().zip(external.chunks_mut(n.max(1))).enumerate() {
        let row = n * s..n * (s + 1);
        let sample = ArmSample {
            period: *period,
            position: &position[row.clone()],
            velocity: &velocity[row.clone()],
            torque: &torque[row],
        };
        observer.update(&sample, external);
    }
    external
}
