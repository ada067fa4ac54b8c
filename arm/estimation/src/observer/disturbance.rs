//! Nonlinear disturbance observer.
//!
//! τ̂_d = z + p with p = Y q̇ and ż = −L (z + p) + L (C q̇ + g − τ_m), L = Y M⁻¹: dτ̂_d/dt = L (τ_d − τ̂_d), where
//! τ_d = τ_ext − τ_f. Here Y is diagonal. The step is implicit in w = Y⁻¹ z, so that no gain makes it unstable:
//! (M + T Y) w_k = M w_{k−1} + T (C q̇ + g − τ_m − Y q̇).
//!
//! # Reference
//! Mohammadi, Tavakoli, Marquez, Hashemzadeh (2013), Nonlinear disturbance observer design for robotic manipulators; Saadatzi et al.
//! (2019), eqs. 9 to 16. Their eq. 12 is d/dt p = L M q̈, and eq. 3 is τ_int = τ_d + τ_f, since friction there is positive with speed.

use hysteron_actuator::law::Sliding;
use hysteron_base::BadInput;

use super::{ArmSample, Dynamics, FrictionModel, Observer};
use hysteron_arm_dynamics::dense;

/// Diagonal gain Y of a disturbance observer, and what it guarantees.
#[derive(Debug, Clone, PartialEq)]
pub struct ObserverGain {
    /// Diagonal of Y, joint by joint [kg m²/s].
    pub y: Vec<f64>,
    /// Greatest diagonal Γ with which the matrix inequality holds: γ_i = (2 y_i − ζ)/y_i² [1/(N m s)].
    pub gamma: Vec<f64>,
    /// Rate at which the error falls at least, min (2 y_i − ζ)/(2 λ_max(M)) [1/s].
    pub decay: f64,
}

impl ObserverGain {
    /// y_i = bandwidth · `inertias`_i: where the arm is at rest and joints are not coupled, the pole of each at that inertia [rad/s].
    ///
    /// `largest` is the largest eigenvalue of M [kg m²], `inertia_rate` the bound ζ on ‖Ṁ‖ [kg m²/s], both over all states that
    /// occur. With X = Y⁻¹ diagonal the inequality [Y + Yᵀ − ζ, Yᵀ; Y, Γ⁻¹] ≥ 0 is 2 y_i − ζ ≥ γ_i y_i² for every joint.
    ///
    /// # Errors
    /// `BadInput` where 2 y_i ≤ ζ, so that no γ_i > 0 exists.
    pub fn for_bandwidth(
        bandwidth: f64,
        inertias: &[f64],
        largest: f64,
        inertia_rate: f64,
    ) -> Result<Self, BadInput> {
        let y: Vec<f64> = inertias.iter().map(|inertia| bandwidth * inertia).collect();
        let margin = y.iter().map(|y| 2.0 * y - inertia_rate).fold(f64::INFINITY, f64::min);
        if !(margin > 0.0 && margin.is_finite()) {
            let least = inertias.iter().map(|inertia| 0.5 * inertia_rate / inertia).fold(0.0, f64::max);
            return Err(BadInput::new(
                "bandwidth of the disturbance observer",
                format!("more than {least:.3} rad/s, for an inertia that changes by {inertia_rate} kg m²/s"),
                format!("{bandwidth} rad/s"),
            ));
        }
        let gamma = y.iter().map(|y| (2.0 * y - inertia_rate) / (y * y)).collect();
        Ok(Self { y, gamma, decay: 0.5 * margin / largest })
    }
}

/// Estimates external torques through τ̂_d.
#[derive(Debug, Clone)]
pub struct DisturbanceObserver<D> {
    dynamics: D,
    friction: FrictionModel,
    y: Vec<f64>,
    is_started: bool,
    /// w = Y⁻¹ z [rad/s].
    memory: Vec<f64>,
    bias: Vec<f64>,
    mass: Vec<f64>,
    side: Vec<f64>,
}

impl<D: Dynamics> DisturbanceObserver<D> {
    /// With the gain `gain`.
    pub fn new(dynamics: D, friction: FrictionModel, gain: &ObserverGain) -> Self {
        let n = dynamics.n_joints();
        assert_eq!(n, friction.n_joints());
        let row = || vec![0.0; n];
        Self {
            dynamics,
            friction,
            y: gain.y.clone(),
            is_started: false,
            memory: row(),
            bias: row(),
            mass: vec![0.0; n * n],
            side: row(),
        }
    }

    /// w after the sample, from w before it.
    fn step(&mut self, sample: &ArmSample) {
        let (n, h) = (self.bias.len(), sample.period);
        self.dynamics.mass(sample.position, &mut self.mass);
        for i in 0..n {
            let row = &self.mass[n * i..n * (i + 1)];
            let inertia: f64 = row.iter().zip(&self.memory).map(|(m, w)| m * w).sum();
            let drive = self.bias[i] - sample.torque[i] - self.y[i] * sample.velocity[i];
            self.side[i] = inertia + h * drive;
        }
        for i in 0..n {
            self.mass[n * i + i] += h * self.y[i];
        }
        dense::factor(n, &mut self.mass);
        dense::solve_columns(n, &self.mass, &mut self.side);
        self.memory.copy_from_slice(&self.side);
    }
}

impl<D: Dynamics> Observer for DisturbanceObserver<D> {
    fn update(&mut self, sample: &ArmSample, external: &mut [f64]) {
        if !std::mem::replace(&mut self.is_started, true) {
            for (w, dq) in self.memory.iter_mut().zip(sample.velocity) {
                *w = -dq;
            }
            external.fill(0.0);
            return;
        }
        self.dynamics.bias(sample.position, sample.velocity, &mut self.bias);
        self.step(sample);
        for (j, external) in external.iter_mut().enumerate() {
            let disturbance = self.y[j] * (self.memory[j] + sample.velocity[j]);
            let at = Sliding {
                velocity: sample.velocity[j],
                motor_torque: sample.torque[j],
                load_torque: -self.bias[j],
            };
            *external = disturbance + self.friction.follow(j, &at, [-disturbance; 2]);
        }
    }

    fn reset(&mut self) {
        self.is_started = false;
        self.friction.reset();
    }
}
