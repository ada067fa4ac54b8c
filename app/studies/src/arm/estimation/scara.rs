//! External torques of a simulated SCARA by momentum observers with friction from every method of identification.
//!
//! # Reference
//! Wan et al. (2026), sections 2.4 and 3.4 to 3.6: tables 4 and 5, figures 15, 16, 18 and 19.

use std::f64::consts::TAU;

use hysteron_actuator::law::Law;
use hysteron_base::BadInput;
use serde::{Deserialize, Serialize};

use super::normal;
use super::plant::{Controller, Imperfections, Plant, PlantTrial, TrueFriction};
use super::scara_friction::{FrictionCell, METHODS, TRIAL_NOISE, TRUE, law_of};
use hysteron_arm_dynamics::{ExternalForce, Model};
use hysteron_arm_estimation::observer::{FrictionModel, LowSpeed, MomentumObserver, RigidBody, estimate};

/// Time between samples: 400 Hz [s].
pub const PERIOD: f64 = 2.5e-3;
/// K of the joints [1/s].
pub const GAINS: [f64; 2] = [50.0, 30.0];
/// Steps of encoders on the motors, converted to the joints [rad].
const ENCODER_STEP: f64 = TAU / 500_000.0;
/// Speed below which friction is a line through zero [rad/s].
const LINE: f64 = 0.01;
/// By how much the masses that the estimators know are too large [-].
const MASS_ERROR: f64 = 0.02;
/// Rows of figures: every so many samples.
const DECIMATION: usize = 8;
/// Names of the methods: "none" is the observer without friction.
pub const OBSERVERS: [&str; 6] =
    ["anfis", "fnn", "pso", "least-squares-coulomb", "least-squares-stribeck", "none"];

/// How one observer did.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct ObserverRow {
    /// Name of [`OBSERVERS`].
    pub method: String,
    /// Root mean square error, joint by joint [N m].
    pub rmse_n_m: [f64; 2],
    /// Largest error [N m].
    pub max_n_m: [f64; 2],
    /// Least [N m].
    pub min_n_m: [f64; 2],
    /// Mean [N m].
    pub mean_n_m: [f64; 2],
    /// Coefficient of determination [-].
    pub r2: [f64; 2],
    /// Estimates of the first trial at the times of the figures, joint by joint [N m].
    pub estimate: [Vec<f64>; 2],
}

/// External torques while the arm is led by the hand: table 4.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct TeachingCell {
    /// Seed of all draws.
    pub seed: u64,
    /// Standard deviation of the true torques [N m].
    pub truth_deviation_n_m: [f64; 2],
    /// The observers.
    pub rows: Vec<ObserverRow>,
    /// Times of the figures' rows [s].
    pub time_s: Vec<f64>,
    /// Torques by the force sensor at those times [N m].
    pub truth: [Vec<f64>; 2],
}

/// The observer with the friction that `method` found; the masses in the estimators' models are too large.
pub struct Methods {
    assumed: Model,
    friction: Vec<(String, FrictionModel)>,
}

impl Methods {
    /// From what was identified on both joints.
    ///
    /// # Errors
    /// None, unless the files of the program are damaged.
    pub fn new(cells: &[FrictionCell; 2]) -> Result<Self, BadInput> {
        let assumed = Model::builtin("scara")?.with_scaled_bodies(1.0 + MASS_ERROR);
        let law = |method: &str, k: usize| -> (Law, Vec<f64>) {
            (
                law_of(method),
                cells[k]
                    .rows
                    .iter()
                    .find(|row| row.method == method)
                    .map_or(vec![], |row| row.parameters.clone()),
            )
        };
        let mut friction: Vec<(String, FrictionModel)> = METHODS
            .iter()
            .map(|method| {
                let laws = vec![law(method, 0), law(method, 1)];
                ((*method).to_owned(), FrictionModel::new(laws, LowSpeed::Linear(LINE)))
            })
            .collect();
        friction.push(("none".to_owned(), FrictionModel::none(2)));
        Ok(Self { assumed, friction })
    }

    /// Estimates of every method on a trial, row by row.
    pub(super) fn estimates(&self, trial: &PlantTrial) -> Vec<(&str, Vec<f64>)> {
        let speeds = differences(trial);
        let periods = vec![PERIOD; trial.position.len() / 2];
        let run = |friction: &FrictionModel| {
            let mut observer = MomentumObserver::new(RigidBody::new(&self.assumed), friction.clone(), &GAINS);
            estimate(&mut observer, &periods, [&trial.position, &speeds, &trial.torque])
        };
        self.friction.iter().map(|row| (row.0.as_str(), run(&row.1))).collect()
    }
}

/// Speeds as differences of the encoders, row by row.
pub(super) fn differences(trial: &PlantTrial) -> Vec<f64> {
    let q = &trial.position;
    (0..q.len()).map(|k| if k < 2 { 0.0 } else { (q[k] - q[k - 2]) / PERIOD }).collect()
}

pub(super) fn plant(model: &Model) -> Plant<'_> {
    let friction = TRUE.iter().zip([1e5, 5e4]).map(|(curve, stiffness)| TrueFriction {
        curve: Box::new(|v| curve.size(v)),
        stiffness,
        damping: 100.0,
        scale: 1.0,
        ripple: 0.01,
    });
    let imperfections =
        Imperfections { encoder_step: ENCODER_STEP, torque_error: 0.0, torque_noise: TRIAL_NOISE };
    Plant::new(model, friction.collect(), imperfections, PERIOD)
}

/// Damped to about 0.6 of the critical; a sample's change of speed by the damping is at most a third of the speed, so that the sampled
/// controller is stable without friction too.
pub(super) fn controller() -> Controller {
    Controller { stiffness: vec![1000.0, 100.0], damping: vec![20.0, 2.0] }
}

/// On and on in one direction at speeds that change: the hand leads, the robot reverses nowhere.
pub(super) fn lead(t: f64) -> [Vec<f64>; 3] {
    let row = |speed: f64, swing: f64, w: f64| {
        let (sin, cos) = (w * t).sin_cos();
        [speed * t - swing / w * (cos - 1.0), speed + swing * sin, swing * w * cos]
    };
    let rows = [row(0.4, 0.25, TAU * 0.23), row(0.5, 0.3, TAU * 0.31)];
    [0, 1, 2].map(|k| rows.iter().map(|row| row[k]).collect())
}

/// A force at the tip across the second link, which has its full lever of 0.175 m, where the arm is meant to be at `t`.
pub(super) fn tip_force(tip: usize, t: f64, force: f64) -> Vec<ExternalForce<f64>> {
    let [q, ..] = lead(t);
    let (sin, cos) = (q[0] + q[1]).sin_cos();
    vec![ExternalForce { frame: tip, force: [-force * sin, force * cos, 0.0], torque: [0.0; 3] }]
}

/// Led by the hand: `n_trials` of 12 s, 0.3 Hz forces that change in size, of both signs.
///
/// # Errors
/// None, unless the files of the program are damaged.
pub fn teaching_cell(methods: &Methods, n_trials: usize, seed: u64) -> Result<TeachingCell, BadInput> {
    let model = Model::builtin("scara")?;
    let tip = model.frame("tip")?;
    let (plant, warm_up) = (plant(&model), 400);
    let mut sums: Vec<Sums> = vec![Sums::default(); OBSERVERS.len()];
    let mut first: Option<(PlantTrial, Vec<[Vec<f64>; 2]>)> = None;
    for k in 0..n_trials {
        let mut noise = normal(seed, &format!("scara/teaching/{k}"));
        let (phase, size) = (TAU * (noise() / 6.0), 20.0 + 2.0 * noise());
        let loading = |t: f64| tip_force(tip, t, size * (TAU * 0.3 * t + phase).sin());
        let trial = plant.run(&lead, &controller(), &loading, 12.0, &mut noise);
        let estimates = methods.estimates(&trial);
        for (sum, (_, rows)) in sums.iter_mut().zip(&estimates) {
            sum.add(&rows[2 * warm_up..], &trial.external[2 * warm_up..]);
        }
        if first.is_none() {
            let shown = estimates.iter().map(|(_, rows)| decimated(rows)).collect();
            first = Some((trial, shown));
        }
    }
    let (trial, shown) = first.ok_or_else(|| BadInput::new("trials", "at least one", "0"))?;
    let rows = OBSERVERS.iter().zip(&sums).zip(shown).map(|((name, sum), estimate)| sum.row(name, estimate));
    Ok(TeachingCell {
        seed,
        truth_deviation_n_m: [0, 1].map(|j| sums[0].deviation(j)),
        rows: rows.collect(),
        time_s: (0..trial.position.len() / 2).step_by(DECIMATION).map(|k| k as f64 * PERIOD).collect(),
        truth: decimated(&trial.external),
    })
}

fn decimated(rows: &[f64]) -> [Vec<f64>; 2] {
    [0, 1].map(|j| rows.iter().skip(j).step_by(2 * DECIMATION).copied().collect())
}

/// Sums of errors and of the truth, joint by joint.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sums {
    n: [f64; 2],
    squares: [f64; 2],
    sizes: [f64; 2],
    pub(super) extremes: [[f64; 2]; 2],
    truth: [[f64; 2]; 2],
}

impl Default for Sums {
    fn default() -> Self {
        let zero = [0.0; 2];
        Self { n: zero, squares: zero, sizes: zero, extremes: [[f64::INFINITY; 2], zero], truth: [zero; 2] }
    }
}

impl Sums {
    pub(super) fn add(&mut self, rows: &[f64], truth: &[f64]) {
        for (k, (a, b)) in rows.iter().zip(truth).enumerate() {
            let (j, error) = (k % 2, (a - b).abs());
            self.n[j] += 1.0;
            self.squares[j] += error * error;
            self.sizes[j] += error;
            self.extremes[0][j] = self.extremes[0][j].min(error);
            self.extremes[1][j] = self.extremes[1][j].max(error);
            self.truth[0][j] += b;
            self.truth[1][j] += b * b;
        }
    }

    /// Standard deviation of the truth.
    fn deviation(&self, j: usize) -> f64 {
        (self.truth[1][j] / self.n[j] - (self.truth[0][j] / self.n[j]).powi(2)).sqrt()
    }

    pub(super) fn rmse(&self) -> [f64; 2] {
        [0, 1].map(|j| (self.squares[j] / self.n[j]).sqrt())
    }

    fn row(&self, name: &str, estimate: [Vec<f64>; 2]) -> ObserverRow {
        let rmse_n_m = self.rmse();
        ObserverRow {
            method: name.to_owned(),
            rmse_n_m,
            max_n_m: self.extremes[1],
            min_n_m: self.extremes[0],
            mean_n_m: [0, 1].map(|j| self.sizes[j] / self.n[j]),
            r2: [0, 1].map(|j| 1.0 - (rmse_n_m[j] / self.deviation(j)).powi(2)),
            estimate,
        }
    }
}
