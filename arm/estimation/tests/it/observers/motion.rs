//! Motions in closed form with the torques that they need.

use hysteron_arm_dynamics::{Data, Model, inverse_dynamics};
use hysteron_arm_estimation::observer::{ArmSample, Observer};

/// The Panda without its fingers: seven joints.
pub fn panda() -> Model {
    let panda = Model::builtin("panda").unwrap();
    let fingers: Vec<(&str, f64)> =
        panda.joints()[7..].iter().map(|joint| (joint.name.as_str(), 0.01)).collect();
    panda.with_locked(&fingers).unwrap()
}

/// q_j = a sin(w_j t + j): coordinates, speeds, accelerations.
pub fn sines(n: usize, t: f64) -> [Vec<f64>; 3] {
    let part = |f: &dyn Fn(f64, f64) -> f64| (0..n).map(|j| f(1.0 + 0.3 * j as f64, j as f64)).collect();
    let a = 0.6;
    [
        part(&|w, phase| a * (w * t + phase).sin()),
        part(&|w, phase| a * w * (w * t + phase).cos()),
        part(&|w, phase| -a * w * w * (w * t + phase).sin()),
    ]
}

/// Motor torque of the sines at `t` under the external torques.
pub fn torque_at(model: &Model, t: f64, external: &[f64]) -> Vec<f64> {
    let [q, dq, ddq] = sines(model.n_joints(), t);
    let mut tau = vec![0.0; q.len()];
    inverse_dynamics(model, &mut Data::new(model, 0.0), [&q, &dq, &ddq], &[], &mut tau);
    tau.iter().zip(external).map(|(tau, f)| tau - f).collect()
}

/// Its mean from t − h to t, by Simpson's rule on the parts before and after `at`, where the external torque jumps.
fn mean_torque(model: &Model, [from, to]: [f64; 2], external: &dyn Fn(f64) -> Vec<f64>) -> Vec<f64> {
    let samples = [(from, 1.0 / 6.0), (0.5 * (from + to), 4.0 / 6.0), (to, 1.0 / 6.0)];
    let constant = external(0.5 * (from + to));
    let mut mean = vec![0.0; model.n_joints()];
    for (t, weight) in samples {
        for (mean, tau) in mean.iter_mut().zip(torque_at(model, t, &constant)) {
            *mean += weight * tau;
        }
    }
    mean
}

/// The estimates of `observer` along the sines, sampled at `period`, under an external torque that is constant over each period.
pub fn run(
    observer: &mut dyn Observer,
    model: &Model,
    (period, n_samples): (f64, usize),
    external: &dyn Fn(f64) -> Vec<f64>,
) -> Vec<Vec<f64>> {
    let n = model.n_joints();
    let mut out = vec![0.0; n];
    (0..n_samples)
        .map(|k| {
            let t = k as f64 * period;
            let [q, dq, _] = sines(n, t);
            let tau = mean_torque(model, [t - period, t], external);
            observer.update(&ArmSample { period, position: &q, velocity: &dq, torque: &tau }, &mut out);
            out.clone()
        })
        .collect()
}

/// Largest number of all.
pub fn largest(rows: &[Vec<f64>]) -> f64 {
    rows.iter().flatten().fold(0.0, |m, x| m.max(x.abs()))
}
