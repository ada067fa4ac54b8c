//! Data of a simulated arm: random sinusoids between two poses, with torques and all their parts.

use hysteron_base::rng;
use rand::RngExt;

use super::{ArmSamples, Decomposition};
use hysteron_arm_dynamics::{
    Data, Model, coriolis_matrix, coriolis_torque, gravity_torque, inverse_dynamics, mass_matrix,
};

/// How trajectories are drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sinusoids {
    /// How many.
    pub trajectories: usize,
    /// T of (12) [s].
    pub duration: f64,
    /// Samples per second.
    pub rate: f64,
    /// 1 for the speed as it is; the same ways are gone through so many times as fast.
    pub speed: f64,
}

impl Sinusoids {
    /// As published: 8 s at 50 Hz.
    pub fn published(trajectories: usize) -> Self {
        Self { trajectories, duration: 8.0, rate: 50.0, speed: 1.0 }
    }
}

/// Samples along q(t) = q₀ + (q_f − q₀)/T (t − T/2π sin 2πt/T), (12), between poses drawn uniformly within the joints'
/// limits, with momenta, and the true parts of their torques. `stream` names the random numbers of `seed`.
///
/// # Reference
/// Li et al. (2025), section 4.3.1.
pub fn sinusoids(model: &Model, plan: &Sinusoids, seed: u64, stream: &str) -> (ArmSamples, Decomposition) {
    let n = model.n_joints();
    let mut rng = rng(seed, stream);
    let mut data = Data::new(model, 0.0);
    let (mut samples, mut truth) = (ArmSamples::new(n), Decomposition::default());
    let steps = (plan.duration * plan.rate).round() as usize;
    for _ in 0..plan.trajectories {
        let mut pose = || -> Vec<f64> {
            model.joints().iter().map(|joint| position(joint.drive.range, &mut rng)).collect()
        };
        let ends = [pose(), pose()];
        let first = samples.len();
        for step in 0..steps {
            let phase = std::f64::consts::TAU * step as f64 / steps as f64;
            let rate = plan.speed / plan.duration;
            let (sin, cos) = phase.sin_cos();
            for (from, to) in ends[0].iter().zip(&ends[1]) {
                let way = to - from;
                samples.q.push(from + way * (phase - sin) / std::f64::consts::TAU);
                samples.dq.push(way * rate * (1.0 - cos));
                samples.ddq.push(way * rate * rate * std::f64::consts::TAU * sin);
            }
            add_torques(model, &mut data, &mut samples, &mut truth);
        }
        samples.trajectories.push(first..samples.len());
    }
    (samples, truth)
}

/// A position within limits; joints without any turn all the way.
fn position(range: Option<[f64; 2]>, rng: &mut impl RngExt) -> f64 {
    let [low, high] = range.unwrap_or([-std::f64::consts::PI, std::f64::consts::PI]);
    rng.random_range(low..high)
}

/// Torques, their parts and momenta of the last motion.
fn add_torques(model: &Model, data: &mut Data<f64>, samples: &mut ArmSamples, truth: &mut Decomposition) {
    let n = model.n_joints();
    let at = samples.q.len() - n;
    let (q, dq, ddq) = (&samples.q[at..], &samples.dq[at..], &samples.ddq[at..]);
    let mut tau = vec![0.0; n];
    inverse_dynamics(model, data, [q, dq, ddq], &[], &mut tau);
    samples.tau.extend_from_slice(&tau);
    truth.torque.extend_from_slice(&tau);
    gravity_torque(model, data, q, &mut tau);
    truth.gravity.extend_from_slice(&tau);
    coriolis_torque(model, data, [q, dq], &mut tau);
    truth.coriolis.extend_from_slice(&tau);
    truth.other.resize(samples.q.len(), 0.0);
    let (mut mass, mut coriolis) = (vec![0.0; n * n], vec![0.0; n * n]);
    mass_matrix(model, data, q, &mut mass);
    coriolis_matrix(model, data, [q, dq], &mut coriolis);
    for i in 0..n {
        let row = |matrix: &[f64], x: &[f64]| (0..n).map(|j| matrix[n * i + j] * x[j]).sum::<f64>();
        let column = |matrix: &[f64], x: &[f64]| (0..n).map(|j| matrix[n * j + i] * x[j]).sum::<f64>();
        let inertial = row(&mass, ddq);
        truth.inertial.push(inertial);
        samples.momenta[0].push(row(&mass, dq));
        // Ṁ = C + Cᵀ.
        samples.momenta[1].push(inertial + row(&coriolis, dq) + column(&coriolis, dq));
    }
}
