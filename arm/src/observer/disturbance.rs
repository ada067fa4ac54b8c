//! Nonlinear disturbance observer.
//!
//! τ̂_d = z + p with p = Y q̇ and ż = −L (z + p) + L (C q̇ + g − τ_m), L = Y M⁻¹: dτ̂_d/dt = L (τ_d − τ̂_d), where
//! τ_d = τ_ext − τ_f. Here Y = y 1. The step is implicit, so that no gain makes it unstable:
//! (M/y + T) z_k = M/y z_{k−1} + T (C q̇ + g − τ_m − p).
//!
//! # Reference
//! Mohammadi, Tavakoli, Marquez, Hashemzadeh (2013), Nonlinear disturbance observer design for robotic manipulators; Saadatzi et al.
//! (2019), eqs. 9 to 16. Their eq. 12 is d/dt p = L M q̈, and eq. 3 is τ_int = τ_d + τ_f, since friction there is positive with speed.

use hysteron_actuator::law::Sliding;
use hysteron_base::BadInput;

use super::{Dynamics, FrictionModel, Observer, Sample};
use crate::dense;

/// Gain Y = y 1 of a disturbance observer, and what it guarantees.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ObserverGain {
    /// y [kg m²/s].
    pub y: f64,
    /// Greatest γ with which the matrix inequality holds, Γ = γ 1: γ = (2y − ζ)/y² [1/(N m s)].
    pub gamma: f64,
    /// Rate at which the error falls at least, (2y − ζ)/(2 λ_max(M)) [1/s].
    pub decay: f64,
}

impl ObserverGain {
    /// The gain whose slowest pole has `bandwidth` [rad/s] where the arm stands: y = bandwidth · λ_max(M).
    ///
    /// `inertia` is the largest eigenvalue of M [kg m²], `inertia_rate` the bound ζ on ‖Ṁ‖ [kg m²/s], both over all states that
    /// occur. With X = Y⁻¹ = 1/y the inequality [Y + Yᵀ − ζ, Yᵀ; Y, Γ⁻¹] ≥ 0 is 2y − ζ ≥ γ y².
    ///
    /// # Errors
    /// `BadInput` where 2y ≤ ζ, so that no γ > 0 exists.
    pub fn for_bandwidth(bandwidth: f64, inertia: f64, inertia_rate: f64) -> Result<Self, BadInput> {
        let y = bandwidth * inertia;
        let margin = 2.0 * y - inertia_rate;
        if !(margin > 0.0 && y.is_finite()) {
            let least = 0.5 * inertia_rate / inertia;
            return Err(BadInput::new(
                "bandwidth of the disturbance observer",
                format!("more than {least:.3} rad/s, for an inertia that changes by {inertia_rate} kg m²/s"),
                format!("{bandwidth} rad/s"),
            ));
        }
        Ok(Self { y, gamma: margin / (y * y), decay: 0.5 * margin / inertia })
    }
}

/// Estimates external torques through τ̂_d.
#[derive(Debug, Clone)]
pub struct DisturbanceObserver<D> {
    dynamics: D,
    friction: FrictionModel,
    y: f64,
    is_started: bool,
    /// z [N m].
    memory: Vec<f64>,
    bias: Vec<f64>,
    mass: Vec<f64>,
    side: Vec<f64>,
}

impl<D: Dynamics> DisturbanceObserver<D> {
    /// With the gain `gain`.
    pub fn new(dynamics: D, friction: FrictionModel, gain: ObserverGain) -> Self {
        let n = dynamics.n_joints();
        assert_eq!(n, friction.n_joints());
        let row = || vec![0.0; n];
        Self {
            dynamics,
            friction,
            y: gain.y,
            is_started: false,
            memory: row(),
            bias: row(),
            mass: vec![0.0; n * n],
            side: row(),
        }
    }

    /// z after the sample, from z before it.
    fn step(&mut self, sample: &Sample) {
        let (n, h) = (self.bias.len(), sample.period);
        self.dynamics.mass(sample.position, &mut self.mass);
        self.mass.iter_mut().for_each(|m| *m /= self.y);
        for i in 0..n {
            let row = &self.mass[n * i..n * (i + 1)];
            let inertia: f64 = row.iter().zip(&self.memory).map(|(m, z)| m * z).sum();
            let drive = self.bias[i] - sample.torque[i] - self.y * sample.velocity[i];
            self.side[i] = inertia + h * drive;
        }
        for i in 0..n {
            self.mass[n * i + i] += h;
        }
        dense::factor(n, &mut self.mass);
        dense::solve_columns(n, &self.mass, &mut self.side);
        self.memory.copy_from_slice(&self.side);
    }
}

impl<D: Dynamics> Observer for DisturbanceObserver<D> {
    fn update(&mut self, sample: &Sample, external: &mut [f64]) {
        if !std::mem::replace(&mut self.is_started, true) {
            for (z, dq) in self.memory.iter_mut().zip(sample.velocity) {
                *z = -self.y * dq;
            }
            external.fill(0.0);
            return;
        }
        self.dynamics.bias(sample.position, sample.velocity, &mut self.bias);
        self.step(sample);
        for (j, external) in external.iter_mut().enumerate() {
            let disturbance = self.memory[j] + self.y * sample.velocity[j];
            let at = Sliding {
                velocity: sample.velocity[j],
                motor_torque: sample.torque[j],
                load_torque: -self.bias[j],
            };
            *external = disturbance + self.friction.torque(j, &at, -disturbance);
        }
    }

    fn reset(&mut self) {
        self.is_started = false;
    }
}
