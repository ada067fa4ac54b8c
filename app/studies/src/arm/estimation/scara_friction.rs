//! Friction of a SCARA's joints from torques at constant speeds, by every method of the paper and by the least squares of the right law.
//!
//! # Reference
//! Wan et al. (2026), sections 2.3 and 3.2: table 2, figures 10 to 12 and 14. Parameters of the true curve: table 2, ANFIS, except the
//! Stribeck speeds, which are unphysical there (V_s ≈ f_s in every column) and are taken as 0.2 rad/s.

use hysteron_actuator::filter::{LowPass, median_of};
use hysteron_actuator::identify::{FrictionMethod, identify_friction_by};
use hysteron_actuator::law::{CoulombViscous, DirectedStribeck, JointFriction, Law, Sliding};
use hysteron_base::BadInput;
use serde::{Deserialize, Serialize};

use super::normal;

/// Friction f_c⁺, f_c⁻, f_s⁺, f_s⁻ [N m], v_s [rad/s], f_v [N m s/rad] of a joint.
#[derive(Debug, Clone, Copy)]
pub struct TrueStribeck(pub [f64; 6]);

/// Table 2, ANFIS, joints 1 and 2.
pub const TRUE: [TrueStribeck; 2] = [
    TrueStribeck([6.17, 6.26, 11.15, 10.99, 0.2, 12.1787]),
    TrueStribeck([2.92, 2.83, 4.30, 4.55, 0.2, 5.0402]),
];
/// Standard deviation of the torque of one trial [N m].
pub const TRIAL_NOISE: f64 = 0.43;
/// Trials at each speed.
const TRIALS: usize = 200;
/// Training points, of 200.
const N_TRAINING: usize = 140;

impl TrueStribeck {
    /// Size of friction at a speed, eq. 3 by direction [N m].
    pub fn size(&self, v: f64) -> f64 {
        let [fc_plus, fc_minus, fs_plus, fs_minus, v_s, f_v] = self.0;
        let (fc, fs) = if v > 0.0 { (fc_plus, fs_plus) } else { (fc_minus, fs_minus) };
        fc + (fs - fc) * (-(v / v_s) * (v / v_s)).exp() + f_v * v.abs()
    }
}

/// How friction is identified; the first four are the paper's.
pub const METHODS: [&str; 5] = ["anfis", "fnn", "pso", "least-squares-coulomb", "least-squares-stribeck"];

/// One method on one joint.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct FrictionRow {
    /// Name of [`METHODS`].
    pub method: String,
    /// Parameters of the law: Stribeck by direction, or Coulomb and viscous.
    pub parameters: Vec<f64>,
    /// From single trials: root mean square and largest error of the law against the true curve over 0.01 to 1 rad/s [N m].
    pub single_error_n_m: [f64; 2],
    /// The same from means of 200 trials.
    pub averaged_error_n_m: [f64; 2],
    /// Root mean square error of five folds, in training and in testing [N m].
    pub folds_n_m: Vec<[f64; 2]>,
    /// Error over the iterations [N m]: figure 10.
    pub progress_n_m: Vec<f64>,
}

/// One joint.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct FrictionCell {
    /// Joint, from 0.
    pub joint: usize,
    /// Seed of all draws.
    pub seed: u64,
    /// Measured points of single trials: speed [rad/s] and torque [N m].
    pub points: Vec<(f64, f64)>,
    /// The methods.
    pub rows: Vec<FrictionRow>,
}

/// Speeds ±0.01 … ±1 rad/s.
fn speeds() -> Vec<f64> {
    (1..=100).flat_map(|k| [0.01 * f64::from(k), -0.01 * f64::from(k)]).collect()
}

/// The law with which a method ends.
pub fn law_of(method: &str) -> Law {
    if method == "least-squares-coulomb" {
        Law::CoulombViscous(CoulombViscous)
    } else {
        Law::DirectedStribeck(DirectedStribeck)
    }
}

/// Torque of friction that `method` found, at a speed [N m].
pub fn torque(row: &FrictionRow, velocity: f64) -> f64 {
    law_of(&row.method).torque(&row.parameters, &Sliding::at(velocity))
}

/// Torques of single trials in the order of their speeds, and what each method leaves of them, through a median of five and a zero-phase
/// low pass of a tenth of the samples' rate: speeds [rad/s], torques [N m], what is left by each method [N m].
pub fn compensated(cell: &FrictionCell) -> (Vec<f64>, Vec<f64>, Vec<Vec<f64>>) {
    let mut points = cell.points.clone();
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    let smooth = |values: Vec<f64>| {
        let values = median_of(&values, 2);
        match LowPass::new(4, 0.1, 1.0) {
            Ok(filter) => filter.zero_phase(&values),
            Err(_) => values,
        }
    };
    let left = |row: &FrictionRow| smooth(points.iter().map(|(v, tau)| tau - torque(row, *v)).collect());
    (
        points.iter().map(|(v, _)| *v).collect(),
        smooth(points.iter().map(|(_, tau)| *tau).collect()),
        cell.rows.iter().map(left).collect(),
    )
}

fn residuals(law: &Law, p: &[f64], points: &[(f64, f64)]) -> Vec<f64> {
    points.iter().map(|(v, tau)| law.torque(p, &Sliding::at(*v)) - tau).collect()
}

fn rms(errors: &[f64]) -> f64 {
    (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt()
}

/// Parameters that `method` finds in `points`, and its error over the iterations.
fn identify(method: &str, points: &[(f64, f64)], seed: u64) -> Result<(Vec<f64>, Vec<f64>), BadInput> {
    let (velocity, torque): (Vec<f64>, Vec<f64>) = points.iter().copied().unzip();
    let by = match method {
        "least-squares-coulomb" | "least-squares-stribeck" => FrictionMethod::LeastSquares,
        name => FrictionMethod::named(name)?,
    };
    let found = identify_friction_by(by, &law_of(method), &velocity, &torque, seed)?;
    Ok((found.parameters, found.progress))
}

/// Error of the law against the true curve: root mean square and largest [N m].
fn against_truth(method: &str, p: &[f64], joint: usize) -> [f64; 2] {
    let truth: Vec<(f64, f64)> =
        speeds().into_iter().map(|v| (v, TRUE[joint].size(v) * v.signum())).collect();
    let errors = residuals(&law_of(method), p, &truth);
    [rms(&errors), errors.iter().fold(0.0, |m: f64, e| m.max(e.abs()))]
}

/// Every method on the torques of one joint.
///
/// # Errors
/// None for the bounds here.
pub fn friction_cell(joint: usize, seed: u64) -> Result<FrictionCell, BadInput> {
    let mut noise = normal(seed, &format!("scara/friction/{joint}"));
    let mut measured = |deviation: f64| -> Vec<(f64, f64)> {
        let at = |v: f64| (v, TRUE[joint].size(v) * v.signum() + deviation * noise());
        let mut points: Vec<(f64, f64)> = speeds().into_iter().map(at).collect();
        shuffle(&mut points, &mut noise_index(seed, joint));
        points
    };
    let (single, averaged) = (measured(TRIAL_NOISE), measured(TRIAL_NOISE / (TRIALS as f64).sqrt()));
    let mut rows = Vec::new();
    for method in METHODS {
        let (parameters, progress_n_m) = identify(method, &single[..N_TRAINING], seed)?;
        let (better, _) = identify(method, &averaged[..N_TRAINING], seed)?;
        let mut folds_n_m = Vec::new();
        for fold in 0..5 {
            let part = |inside: bool| -> Vec<(f64, f64)> {
                let points = single.iter().enumerate();
                points.filter(|(k, _)| (k % 5 == fold) == inside).map(|(_, point)| *point).collect()
            };
            let (training, test) = (part(false), part(true));
            let (p, _) = identify(method, &training, seed)?;
            let error = |points: &[(f64, f64)]| rms(&residuals(&law_of(method), &p, points));
            folds_n_m.push([error(&training), error(&test)]);
        }
        rows.push(FrictionRow {
            method: method.to_owned(),
            single_error_n_m: against_truth(method, &parameters, joint),
            averaged_error_n_m: against_truth(method, &better, joint),
            parameters,
            folds_n_m,
            progress_n_m,
        });
    }
    Ok(FrictionCell { joint, seed, points: single, rows })
}

/// Numbers from 0 to below one, for shuffling.
fn noise_index(seed: u64, joint: usize) -> impl FnMut(usize) -> usize {
    use rand::RngExt;
    let mut random = hysteron_base::rng(seed, &format!("scara/shuffle/{joint}"));
    move |n| random.random_range(0..n)
}

fn shuffle<T>(items: &mut [T], index: &mut impl FnMut(usize) -> usize) {
    for k in (1..items.len()).rev() {
        items.swap(k, index(k + 1));
    }
}
