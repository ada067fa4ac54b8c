//! An identified rigid body with friction and springs at its joints: linear in its parameters.
//!
//! τ_j = (Y π)_j + armature q̈_j + C tanh(q̇_j/0.02 rad/s) + d q̇_j + offset + k q_j + a sin q_j + b cos q_j. The bodies are
//! found twice: by least squares, and among those that can be (every pseudo-inertia positive definite), by P = L Lᵀ of each.

use hysteron_base::parallel;
use hysteron_learn::Lbfgs;
use hysteron_learn::ridge::{NormalEquations, predict};
use rayon::prelude::*;

use crate::lagrangian::ArmSamples;
use hysteron_arm_dynamics::{Data, Model, regressor};

/// Features of a joint in addition to the bodies'.
const OWN: usize = 7;
/// Speed within which dry friction is smooth [rad/s].
const SMOOTH: f64 = 0.02;
/// Samples whose features are in memory at a time.
const ROWS: usize = 256;

/// The features of an arm's torques.
#[derive(Debug, Clone)]
pub struct RigidFeatures<'m> {
    model: &'m Model,
    /// 1/σ of every joint's torque: rows are weighed by it.
    per_torque: Vec<f64>,
}

impl<'m> RigidFeatures<'m> {
    /// Joints are weighed by the spread of their torques in these samples.
    pub fn new(model: &'m Model, training: &ArmSamples) -> Self {
        let per_torque = training.deviations(&training.tau).into_iter().map(|s| 1.0 / s.max(1e-12)).collect();
        Self { model, per_torque }
    }

    /// Features of a joint's torque.
    pub fn width(&self) -> usize {
        (10 + OWN) * self.model.n_joints()
    }

    /// [sample · joint][feature], each row times the joint's weight.
    fn rows(
        &self,
        data: &mut Data<f64>,
        samples: &ArmSamples,
        range: std::ops::Range<usize>,
        out: &mut Vec<f64>,
    ) {
        let n = self.model.n_joints();
        let (width, bodies) = (self.width(), 10 * n);
        let mut y = vec![0.0; n * bodies];
        out.clear();
        out.resize(range.len() * n * width, 0.0);
        for (i, out) in range.zip(out.chunks_exact_mut(n * width)) {
            let part = n * i..n * (i + 1);
            let state = [&samples.q, &samples.dq, &samples.ddq].map(|values| &values[part.clone()]);
            regressor(self.model, data, state, &mut y);
            for j in 0..n {
                let [q, dq, ddq] = state.map(|values| values[j]);
                let row = &mut out[j * width..(j + 1) * width];
                row[..bodies].copy_from_slice(&y[j * bodies..(j + 1) * bodies]);
                let own = [ddq, (dq / SMOOTH).tanh(), dq, 1.0, q, q.sin(), q.cos()];
                row[bodies + OWN * j..][..OWN].copy_from_slice(&own);
                row.iter_mut().for_each(|v| *v *= self.per_torque[j]);
            }
        }
    }

    /// Sums of one trajectory each; every `stride`-th sample is taken.
    pub fn normal_equations(&self, samples: &ArmSamples, stride: usize) -> Vec<NormalEquations> {
        let n = self.model.n_joints();
        let of = |trajectory: &std::ops::Range<usize>| {
            let mut data = Data::new(self.model, 0.0);
            let mut sums = NormalEquations::new(self.width(), 1);
            let mut features = Vec::new();
            for i in trajectory.clone().step_by(stride) {
                self.rows(&mut data, samples, i..i + 1, &mut features);
                let tau = &samples.tau[n * i..n * (i + 1)];
                let weighed: Vec<f64> = tau.iter().zip(&self.per_torque).map(|(t, w)| t * w).collect();
                sums.add(&features, &weighed);
            }
            sums
        };
        parallel::map(&samples.trajectories, of)
    }

    /// Torques [sample][joint] of these parameters.
    pub fn predict(&self, parameters: &[f64], samples: &ArmSamples) -> Vec<f64> {
        let n = self.model.n_joints();
        let mut torques = vec![0.0; samples.len() * n];
        torques.par_chunks_mut(ROWS * n).enumerate().for_each(|(b, out)| {
            let mut data = Data::new(self.model, 0.0);
            let mut features = Vec::new();
            self.rows(&mut data, samples, b * ROWS..b * ROWS + out.len() / n, &mut features);
            predict(&features, parameters, self.width(), out);
            for row in out.chunks_exact_mut(n) {
                row.iter_mut().zip(&self.per_torque).for_each(|(t, w)| *t /= w);
            }
        });
        torques
    }

    /// The parameters nearest to least squares among bodies that can be: every pseudo-inertia is L Lᵀ, armature and friction
    /// are squares.
    ///
    /// # Reference
    /// Rucker, Wensing (2022), Smooth parameterization of rigid-body inertia, by the Cholesky factor of the pseudo-inertia.
    pub fn feasible(&self, sums: &NormalEquations, lambda: f64, iterations: usize) -> Vec<f64> {
        let n = self.model.n_joints();
        let width = self.width();
        let (gram, moments) = (sums.gram(), sums.moments());
        let scale: Vec<f64> = (0..width).map(|i| gram[i * width + i].sqrt().max(1e-9)).collect();
        let target: f64 = scale.iter().map(|s| s * s).sum::<f64>() / width as f64;
        let begin = |k: usize| {
            if k < 10 * n { [0.3, 0.0, 0.0, 0.0, 0.3, 0.0, 0.0, 0.3, 0.0, 1.0][k % 10] } else { 0.1 }
        };
        let mut x: Vec<f64> = (0..width).map(begin).collect();
        let mut function = |x: &[f64], gradient: &mut [f64]| {
            let parameters = Self::physical(x, n);
            let mut value = 0.0;
            let mut by_parameter = vec![0.0; width];
            for i in 0..width {
                let row = &gram[i * width..(i + 1) * width];
                let product: f64 = row.iter().zip(&parameters).map(|(g, p)| g * p).sum();
                let penalty = lambda * scale[i] * scale[i] * parameters[i];
                value += parameters[i] * (0.5 * product - moments[i] + 0.5 * penalty);
                by_parameter[i] = (product - moments[i] + penalty) / target;
            }
            Self::reverse(x, &by_parameter, n, gradient);
            value / target
        };
        let lbfgs = Lbfgs { memory: 40, iterations, gradient_tolerance: 1e-12 };
        lbfgs.minimise(&mut function, &mut x, &mut |_, _, _| true);
        Self::physical(&x, n)
    }

    /// Parameters from unconstrained numbers.
    fn physical(x: &[f64], n: usize) -> Vec<f64> {
        let mut parameters = x.to_vec();
        for (x, p) in x.chunks_exact(10).zip(parameters.chunks_exact_mut(10)).take(n) {
            p.copy_from_slice(&body(x));
        }
        for own in parameters[10 * n..].chunks_exact_mut(OWN) {
            own[..3].iter_mut().for_each(|v| *v *= *v);
        }
        parameters
    }

    /// Derivatives by those numbers.
    fn reverse(x: &[f64], by_parameter: &[f64], n: usize, gradient: &mut [f64]) {
        for ((x, d), g) in
            x.chunks_exact(10).zip(by_parameter.chunks_exact(10)).zip(gradient.chunks_exact_mut(10)).take(n)
        {
            g.copy_from_slice(&body_reverse(x, d));
        }
        let own = 10 * n..x.len();
        let parts = x[own.clone()].chunks_exact(OWN).zip(by_parameter[own.clone()].chunks_exact(OWN));
        for ((x, d), g) in parts.zip(gradient[own].chunks_exact_mut(OWN)) {
            for k in 0..OWN {
                g[k] = if k < 3 { 2.0 * x[k] * d[k] } else { d[k] };
            }
        }
    }
}

/// L (4 × 4, lower) of the pseudo-inertia from ten numbers.
fn lower(x: &[f64]) -> [[f64; 4]; 4] {
    [[x[0], 0.0, 0.0, 0.0], [x[1], x[4], 0.0, 0.0], [x[2], x[5], x[7], 0.0], [x[3], x[6], x[8], x[9]]]
}

/// The ten parameters of a body, in the order of `spatial::Inertia::parameters`, from the factor of its pseudo-inertia.
fn body(x: &[f64]) -> [f64; 10] {
    let l = lower(x);
    let p = |i: usize, j: usize| (0..4).map(|k| l[i][k] * l[j][k]).sum::<f64>();
    ORDER.map(|terms| terms.iter().map(|(sign, i, j)| sign * p(*i, *j)).sum())
}

fn body_reverse(x: &[f64], by: &[f64]) -> [f64; 10] {
    let l = lower(x);
    let mut d = [[0.0; 4]; 4];
    for (terms, by) in ORDER.iter().zip(by) {
        for (sign, i, j) in *terms {
            for k in 0..4 {
                d[*i][k] += by * sign * l[*j][k];
                d[*j][k] += by * sign * l[*i][k];
            }
        }
    }
    [d[0][0], d[1][0], d[2][0], d[3][0], d[1][1], d[2][1], d[3][1], d[2][2], d[3][2], d[3][3]]
}

/// Every parameter as a sum of signed elements of the pseudo-inertia [[Σ, m c], [m cᵀ, m]], Σ = ∫ x xᵀ dm.
const ORDER: [&[(f64, usize, usize)]; 10] = [
    &[(1.0, 3, 3)],
    &[(1.0, 0, 3)],
    &[(1.0, 1, 3)],
    &[(1.0, 2, 3)],
    &[(1.0, 1, 1), (1.0, 2, 2)],
    &[(-1.0, 0, 1)],
    &[(1.0, 0, 0), (1.0, 2, 2)],
    &[(-1.0, 0, 2)],
    &[(-1.0, 1, 2)],
    &[(1.0, 0, 0), (1.0, 1, 1)],
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lagrangian::{Sinusoids, sinusoids};
    use hysteron_arm_dynamics::spatial::Inertia;

    #[test]
    fn an_arm_is_identified_from_its_own_torques() {
        #![allow(clippy::unwrap_used)] // a test may stop where it stands
        let model = Model::builtin("three-link").unwrap();
        let plan = Sinusoids { duration: 2.0, ..Sinusoids::published(12) };
        let (samples, _) = sinusoids(&model, &plan, 1, "test");
        let features = RigidFeatures::new(&model, &samples);
        let mut sums = NormalEquations::new(features.width(), 1);
        features.normal_equations(&samples, 4).iter().for_each(|part| sums.add_scaled(part, 1.0));
        let (other, _) = sinusoids(&model, &plan, 2, "test");
        let nmse = |parameters: &[f64]| {
            crate::lagrangian::TorqueScores::of(3, &other.tau, &features.predict(parameters, &other))
                .sum_nmse()
        };
        // Least squares with a penalty of 1e-12 of the features' squares; the search ends where rounding does.
        let free = nmse(&sums.solve(1e-12));
        assert!(free < 1e-8, "{free}");
        let parameters = features.feasible(&sums, 1e-9, 3000);
        let found = nmse(&parameters);
        assert!(found < 1e-4, "{found}");
        for body in parameters.chunks_exact(10).take(3) {
            let inertia = Inertia::from_parameters(std::array::from_fn(|k| body[k]));
            assert!(inertia.mass > 0.0 && inertia.second[0] > 0.0, "{inertia:?}");
        }
    }

    #[test]
    fn derivatives_of_a_body_are_those_of_differences() {
        let x = [0.7, -0.3, 0.2, 0.5, 0.9, 0.1, -0.4, 0.6, 0.3, 1.1];
        let by: Vec<f64> = (0..10).map(|k| (1.7 * k as f64).cos()).collect();
        let value = |x: &[f64]| body(x).iter().zip(&by).map(|(p, b)| p * b).sum::<f64>();
        let found = body_reverse(&x, &by);
        for k in 0..10 {
            let at = |h: f64| {
                let mut x = x;
                x[k] += h;
                value(&x)
            };
            // Quadratic: central differences are exact but for rounding.
            assert!((found[k] - (at(1e-4) - at(-1e-4)) / 2e-4).abs() < 1e-10, "{k}");
        }
    }
}
