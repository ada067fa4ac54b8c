//! Inverse dynamics and disturbance observer under noise, with a wrong model, and their sensitivity to a parameter.
//!
//! # Reference
//! Saadatzi et al. (2019), sections 2.7 and 3.2: eqs. 17 to 24, figures 7 to 9.

use hysteron_actuator::filter::LowPass;
use hysteron_base::BadInput;
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

use super::normal;
use super::plant::Path;
use hysteron_arm_dynamics::spatial::Inertia;
use hysteron_arm_dynamics::{Data, Model, inverse_dynamics, mass_matrix};
use hysteron_arm_estimation::observer::{
    DisturbanceObserver, Dynamics, FilteredInverseDynamics, FrictionModel, ObserverGain, RigidBody, estimate,
};

/// Dynamics with a constant added to every element of M, C and g.
#[derive(Debug, Clone)]
pub struct OffsetDynamics<D> {
    /// Without.
    pub dynamics: D,
    /// Added to M [kg m²], C [N m s] and g [N m].
    pub offsets: [f64; 3],
}

impl<D: Dynamics> Dynamics for OffsetDynamics<D> {
    fn n_joints(&self) -> usize {
        self.dynamics.n_joints()
    }

    fn gravity(&mut self, q: &[f64], torque: &mut [f64]) {
        self.dynamics.gravity(q, torque);
        torque.iter_mut().for_each(|x| *x += self.offsets[2]);
    }

    fn bias(&mut self, q: &[f64], dq: &[f64], torque: &mut [f64]) {
        self.dynamics.bias(q, dq, torque);
        let more = self.offsets[1] * dq.iter().sum::<f64>() + self.offsets[2];
        torque.iter_mut().for_each(|x| *x += more);
    }

    fn inverse(&mut self, q: &[f64], dq: &[f64], ddq: &[f64], torque: &mut [f64]) {
        self.dynamics.inverse(q, dq, ddq, torque);
        let [mass, coriolis, gravity] = self.offsets;
        let more = mass * ddq.iter().sum::<f64>() + coriolis * dq.iter().sum::<f64>() + gravity;
        torque.iter_mut().for_each(|x| *x += more);
    }

    fn mass(&mut self, q: &[f64], mass: &mut [f64]) {
        self.dynamics.mass(q, mass);
        mass.iter_mut().for_each(|x| *x += self.offsets[0]);
    }

    fn momentum(&mut self, q: &[f64], dq: &[f64], momentum: &mut [f64], rate: &mut [f64]) {
        self.dynamics.momentum(q, dq, momentum, rate);
        let speeds = dq.iter().sum::<f64>();
        momentum.iter_mut().for_each(|x| *x += self.offsets[0] * speeds);
        rate.iter_mut().for_each(|x| *x += self.offsets[1] * speeds - self.offsets[2]);
    }
}

/// Curves over time, joint by joint.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct ErrorComparison {
    /// [s].
    pub time_s: Vec<f64>,
    /// True values; empty where there are none.
    pub truth: Vec<Vec<f64>>,
    /// By inverse dynamics.
    pub inverse_dynamics: Vec<Vec<f64>>,
    /// By the disturbance observer.
    pub disturbance_observer: Vec<Vec<f64>>,
    /// Root mean square error of both, joint by joint; of sensitivities their root mean square.
    pub rms: [Vec<f64>; 2],
}

/// A motion in closed form under a disturbance, without friction.
#[derive(Clone, Copy)]
pub struct Scenario<'a> {
    /// The arm.
    pub model: &'a Model,
    /// Its path.
    pub path: Path<'a>,
    /// External torques at a time [N m].
    pub disturbance: &'a (dyn Fn(f64) -> Vec<f64> + Sync),
    /// [s].
    pub duration: f64,
    /// [s].
    pub period: f64,
}

/// Rows of curves: every so many samples.
const DECIMATION: usize = 20;

impl Scenario<'_> {
    fn n_samples(&self) -> usize {
        (self.duration / self.period) as usize
    }

    /// Coordinates, speeds, motor torques and external torques, row by row.
    fn rows(&self) -> [Vec<f64>; 4] {
        let (mut data, mut rows) = (Data::new(self.model, 0.0), [vec![], vec![], vec![], vec![]]);
        let mut tau = vec![0.0; self.model.n_joints()];
        for k in 0..self.n_samples() {
            let t = k as f64 * self.period;
            let [q, dq, ddq] = (self.path)(t);
            let external = (self.disturbance)(t);
            inverse_dynamics(self.model, &mut data, [&q, &dq, &ddq], &[], &mut tau);
            rows[0].extend(&q);
            rows[1].extend(&dq);
            rows[2].extend(tau.iter().zip(&external).map(|(tau, f)| tau - f));
            rows[3].extend(&external);
        }
        rows
    }

    fn comparison(&self, truth: &[f64], [inverse, observer]: [Vec<f64>; 2]) -> ErrorComparison {
        let n = self.model.n_joints();
        let shown = |rows: &[f64]| -> Vec<Vec<f64>> {
            (0..n).map(|j| rows.iter().skip(j).step_by(n * DECIMATION).copied().collect()).collect()
        };
        // Without the first second, as in the paper's table.
        let from = n * (1.0 / self.period) as usize;
        let rms = [&inverse, &observer].map(|rows| {
            let of = |j: usize| {
                let errors =
                    (from + j..rows.len()).step_by(n).map(|k| rows[k] - truth.get(k).unwrap_or(&0.0));
                (errors.map(|e| e * e).sum::<f64>() / ((rows.len() - from) / n) as f64).sqrt()
            };
            (0..n).map(of).collect()
        });
        ErrorComparison {
            time_s: (0..self.n_samples()).step_by(DECIMATION).map(|k| k as f64 * self.period).collect(),
            truth: if truth.is_empty() { vec![] } else { shown(truth) },
            inverse_dynamics: shown(&inverse),
            disturbance_observer: shown(&observer),
            rms,
        }
    }

    /// Both estimators with noise of `deviation` [rad] on the coordinates, speeds by differences; `gain` of the observer. Figure 7.
    ///
    /// # Errors
    /// A filter that the period does not allow.
    pub fn with_noise(
        &self,
        deviation: f64,
        gain: &ObserverGain,
        seed: u64,
    ) -> Result<ErrorComparison, BadInput> {
        let n = self.model.n_joints();
        let [mut q, _, tau, external] = self.rows();
        let mut noise = normal(seed, "noise");
        q.iter_mut().for_each(|q| *q += deviation * noise());
        let smoothing = LowPass::new(5, 30.0, 1.0 / self.period)?;
        let mut speeds = vec![0.0; q.len()];
        for j in 0..n {
            let [_, first, _] = (self.path)(0.0);
            let mut filter = smoothing.start(first[j]);
            for k in (n + j..q.len()).step_by(n) {
                speeds[k] = filter.next((q[k] - q[k - n]) / self.period);
            }
            speeds[j] = first[j];
        }
        let periods = vec![self.period; self.n_samples()];
        let body = || RigidBody::new(self.model);
        let mut inverse = FilteredInverseDynamics::new(body(), FrictionModel::none(n), smoothing);
        let mut observer = DisturbanceObserver::new(body(), FrictionModel::none(n), gain);
        let rows = [&q[..], &speeds, &tau];
        let both = [estimate(&mut inverse, &periods, rows), estimate(&mut observer, &periods, rows)];
        Ok(self.comparison(&external, both))
    }

    /// Both estimators with `offsets` on every element of M, C and g, without noise or filters. Figure 8.
    pub fn with_wrong_model(&self, offsets: [f64; 3], gain: &ObserverGain) -> ErrorComparison {
        let n = self.model.n_joints();
        let [q, dq, tau, external] = self.rows();
        let wrong = || OffsetDynamics { dynamics: RigidBody::new(self.model), offsets };
        let (mut dynamics, mut needed) = (wrong(), vec![0.0; n]);
        let mut inverse = Vec::with_capacity(q.len());
        for k in 0..self.n_samples() {
            let row = n * k..n * (k + 1);
            let [_, _, ddq] = (self.path)(k as f64 * self.period);
            dynamics.inverse(&q[row.clone()], &dq[row.clone()], &ddq, &mut needed);
            inverse.extend(needed.iter().zip(&tau[row]).map(|(needed, tau)| needed - tau));
        }
        let mut observer = DisturbanceObserver::new(wrong(), FrictionModel::none(n), gain);
        let periods = vec![self.period; self.n_samples()];
        let both = [inverse, estimate(&mut observer, &periods, [&q, &dq, &tau])];
        self.comparison(&external, both)
    }

    /// Derivatives of both estimates by a parameter; `direction` is its change of the ten parameters of every body.
    /// Figure 9.
    ///
    /// Of inverse dynamics it is Y δπ (eq. 22). Of the observer, eq. 23: Ṡ = L (S_ID − S − ∂M M⁻¹ (τ_ID − τ_NDO)), since
    /// ∂L = −L ∂M M⁻¹.
    pub fn sensitivity(&self, direction: &[[f64; 10]], gain: &ObserverGain) -> ErrorComparison {
        let n = self.model.n_joints();
        let (mut data, mut changed) = (Data::new(self.model, 0.0), Data::new(self.model, 0.0));
        changed.inertias = direction.iter().map(|p| Inertia::from_parameters(*p)).collect();
        changed.armature.fill(0.0);
        let gains = DVector::from_column_slice(&gain.y);
        let (mut estimate, mut sensitivity) = (DVector::zeros(n), DVector::zeros(n));
        let [mut inverse, mut observer] = [vec![], vec![]];
        let mut by_parameter = vec![0.0; n];
        for k in 0..self.n_samples() {
            let t = k as f64 * self.period;
            let [q, dq, ddq] = (self.path)(t);
            let matrix = |data: &mut Data<f64>| {
                let mut mass = vec![0.0; n * n];
                mass_matrix(self.model, data, &q, &mut mass);
                DMatrix::from_row_slice(n, n, &mass)
            };
            let (mass, mass_by) = (matrix(&mut data), matrix(&mut changed));
            inverse_dynamics(self.model, &mut changed, [&q, &dq, &ddq], &[], &mut by_parameter);
            let truth = DVector::from_vec((self.disturbance)(t));
            // Implicit steps of x = Y⁻¹ (·): (M + T Y) x_k = M x_{k−1} + T (·).
            let stepped = &mass + self.period * DMatrix::from_diagonal(&gains);
            let Some(factor) = stepped.cholesky() else { break };
            let step = |before: &DVector<f64>, input: &DVector<f64>| {
                factor
                    .solve(&(&mass * before.component_div(&gains) + self.period * input))
                    .component_mul(&gains)
            };
            estimate = step(&estimate, &truth);
            let Some(inertia) = mass.clone().cholesky() else { break };
            let input =
                DVector::from_column_slice(&by_parameter) - &mass_by * inertia.solve(&(&truth - &estimate));
            sensitivity = step(&sensitivity, &input);
            inverse.extend(&by_parameter);
            observer.extend(sensitivity.iter());
        }
        self.comparison(&[], [inverse, observer])
    }
}

/// Change of a body's ten parameters for one more kilogramme at its centre of mass: its second moment about that stays.
pub fn by_mass(body: &Inertia<f64>) -> [f64; 10] {
    let [x, y, z] = body.centre();
    [1.0, x, y, z, y * y + z * z, -x * y, x * x + z * z, -x * z, -y * z, x * x + y * y]
}
