//! The sweep from which the simulated wrist is identified: what its torques are made of, and its friction over speed.
//!
//! # Reference
//! Saadatzi et al. (2019), sections 2.4 and 3.1: figures 5 and 6.

use hysteron_actuator::law::Sliding;
use hysteron_base::BadInput;
use serde::{Deserialize, Serialize};

use super::wrist::{Wrists, friction, identify_wrist, sweep_wrist};
use hysteron_arm_dynamics::{Data, Model, inverse_dynamics};
use hysteron_arm_estimation::identify::JointMotion;

/// Speeds of the friction's figure: from minus to plus this, in so many bins a side [rad/s].
const SPEEDS: (f64, usize) = (2.0, 40);
/// Fewest samples of a bin whose mean is shown.
const MIN_SAMPLES: usize = 5;
/// Rows of figures: every so many samples.
const DECIMATION: usize = 20;

/// Names of the torques, in the order of [`SweepCell::torque`].
pub const TORQUES: [&str; 4] = ["recorded", "CAD", "identified bodies", "identified bodies and friction"];

/// The sweep, joint by joint.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct SweepCell {
    /// Seed of all draws.
    pub seed: u64,
    /// [s].
    pub time_s: Vec<f64>,
    /// Torques as in [`TORQUES`] [N m].
    pub torque: Vec<[Vec<f64>; 2]>,
    /// Root mean square of the recorded torque less each of the other three [N m].
    pub rms_n_m: Vec<[f64; 2]>,
    /// Middles of bins of speed [rad/s].
    pub speed_rad_s: Vec<f64>,
    /// Mean of what the bodies leave of the recorded torque in each bin; not a number where there is hardly a sample [N m].
    pub measured_n_m: [Vec<Option<f64>>; 2],
    /// Friction as identified [N m].
    pub identified_n_m: [Vec<f64>; 2],
    /// True friction in steady motion [N m].
    pub true_n_m: [Vec<f64>; 2],
}

/// Sweeps and identifies the wrist.
///
/// # Errors
/// Of the identification; none for the sweep here.
pub fn sweep_cell(wrists: &Wrists, seed: u64) -> Result<SweepCell, BadInput> {
    let known = identify_wrist(wrists, seed)?;
    let (trial, motion) = sweep_wrist(wrists, seed)?;
    let [cad, bodies] = [&wrists.cad, &known.model].map(|model| torques(model, &motion));
    let rubbing = |k: usize| known.friction.torque(k % 2, &Sliding::at(motion.dq[k]), 0.0);
    let whole: Vec<f64> = bodies.iter().enumerate().map(|(k, tau)| tau + rubbing(k)).collect();
    let by_joint = |rows: &[f64], every: usize| -> [Vec<f64>; 2] {
        [0, 1].map(|j| rows.iter().skip(j).step_by(2 * every).copied().collect())
    };
    let left = |rows: &[f64]| {
        let of = |j: usize| {
            let errors = (j..rows.len()).step_by(2).map(|k| (motion.tau[k] - rows[k]).powi(2));
            (errors.sum::<f64>() / motion.n_samples() as f64).sqrt()
        };
        [of(0), of(1)]
    };
    let (fastest, n) = SPEEDS;
    let width = fastest / n as f64;
    let speed_rad_s: Vec<f64> = (0..2 * n).map(|k| (k as f64 + 0.5) * width - fastest).collect();
    let truth = friction(0.0);
    Ok(SweepCell {
        seed,
        time_s: (0..motion.n_samples()).step_by(DECIMATION).map(|k| k as f64 * trial.period).collect(),
        torque: [&motion.tau, &cad, &bodies, &whole].map(|rows| by_joint(rows, DECIMATION)).to_vec(),
        rms_n_m: [&cad, &bodies, &whole].map(|rows| left(rows)).to_vec(),
        measured_n_m: [0, 1].map(|j| binned(&motion, &bodies, j)),
        identified_n_m: [0, 1]
            .map(|j| speed_rad_s.iter().map(|v| known.friction.torque(j, &Sliding::at(*v), 0.0)).collect()),
        true_n_m: [0, 1]
            .map(|j: usize| speed_rad_s.iter().map(|v| v.signum() * (truth[j].curve)(*v)).collect()),
        speed_rad_s,
    })
}

/// Torques of the bodies along a motion, row by row.
fn torques(model: &Model, motion: &JointMotion) -> Vec<f64> {
    let (mut data, mut rows) = (Data::new(model, 0.0), vec![0.0; motion.q.len()]);
    for (k, tau) in rows.chunks_mut(2).enumerate() {
        let at = 2 * k..2 * k + 2;
        let state = [&motion.q[at.clone()], &motion.dq[at.clone()], &motion.ddq[at]];
        inverse_dynamics(model, &mut data, state, &[], tau);
    }
    rows
}

/// Means over bins of speed of what `bodies` leave of the torque of a joint.
fn binned(motion: &JointMotion, bodies: &[f64], joint: usize) -> Vec<Option<f64>> {
    let (fastest, n) = SPEEDS;
    let mut sums = vec![(0.0, 0_usize); 2 * n];
    for k in (joint..bodies.len()).step_by(2) {
        let bin = ((motion.dq[k] + fastest) / fastest * n as f64).floor();
        if (0.0..2.0 * n as f64).contains(&bin) {
            let (sum, count) = &mut sums[bin as usize];
            *sum += motion.tau[k] - bodies[k];
            *count += 1;
        }
    }
    sums.into_iter().map(|(sum, count)| (count >= MIN_SAMPLES).then(|| sum / count as f64)).collect()
}
