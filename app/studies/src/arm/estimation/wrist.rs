//! Five ways to estimate interaction torques of a wrist exoskeleton, and their baselines, on a simulated one.
//!
//! The true robot is column C of the paper's table 3, made feasible; its friction are bristles that drift. The estimators start from
//! column A (CAD) and identify themselves from a swept sine, as the paper does.
//!
//! # Reference
//! Saadatzi, Long, Celik (2019), Comparison of human-robot interaction torque estimation methods in a wrist rehabilitation
//! exoskeleton: section 2, table 4, figures 7 to 11.

use std::f64::consts::TAU;

use hysteron_actuator::filter::LowPass;
use hysteron_base::BadInput;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::known::{KnownArm, TERMS};
use super::normal;
use super::plant::{Controller, Imperfections, Path, Plant, PlantTrial, TrueFriction};
use super::simulated_errors::{ErrorComparison, Scenario, by_mass};
use hysteron_arm_dynamics::{Data, ExternalForce, Model, inverse_dynamics, mass_matrix};
use hysteron_arm_estimation::identify::{BodyOptions, JointMotion, Smoothing, identify_bodies};
use hysteron_arm_estimation::observer::{
    DisturbanceObserver, FilteredInverseDynamics, KalmanNoise, KalmanObserver, MomentumObserver, Observer,
    ObserverGain, RigidBody, SlidingModeObserver, StaticResidual, Terms, estimate,
};

/// Time between samples [s].
const PERIOD: f64 = 1e-3;
/// Duration of every trial [s].
const DURATION: f64 = 12.0;
/// Bandwidth of the observers, and of their baseline [rad/s]. Chosen once: a lag of 20 ms.
const BANDWIDTH: f64 = 50.0;
/// Steps of the encoders: 2000 a turn of motors geared 15 : 1 [rad].
const ENCODER_STEP: f64 = TAU / 30_000.0;
/// Mean true torques that the loads are scaled to, both joints together [N m]: paper's payload and sensor tests.
const SENSOR_MEAN: f64 = 0.42 + 0.205;
/// Speeds within which friction may be a line through zero, the last as in the paper [rad/s].
const LINES: [f64; 4] = [0.02, 0.05, 0.1, 0.2];
/// Middle of the sweep: between the postures of the tests [rad].
const SWEPT_ABOUT: f64 = 0.85;
/// Samples of the first second, which do not count.
const WARM_UP: usize = 1000;
/// Rows of figures: every so many samples.
const DECIMATION: usize = 20;

/// Load of the wrist.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Load {
    /// A mass of 0.3 kg at the handle.
    Payload,
    /// A string that pulls the handle up.
    ForceSensor,
}

impl Load {
    /// As in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Payload => "payload",
            Self::ForceSensor => "force-sensor",
        }
    }
}

/// One cell of the table: every method under one load and one friction.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct WristCell {
    /// Load of the trial.
    pub load: Load,
    /// Change of the friction after identification [-].
    pub drift: f64,
    /// Seed of all draws.
    pub seed: u64,
    /// Residual of the identification, joint by joint [N m].
    pub identified_rms_n_m: [f64; 2],
    /// Mean of the size of the true torque [N m].
    pub mean_truth_n_m: [f64; 2],
    /// The methods, in the order of [`METHODS`].
    pub methods: Vec<WristMethod>,
    /// Times of the figures' rows [s].
    pub time_s: Vec<f64>,
    /// True torques at those times, joint by joint [N m].
    pub truth: [Vec<f64>; 2],
}

/// One method in one cell.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct WristMethod {
    /// Name of [`METHODS`].
    pub name: String,
    /// Mean error, joint by joint [N m].
    pub error_n_m: [f64; 2],
    /// The same over the mean truth [%].
    pub error_percent: [f64; 2],
    /// Estimates at the times of the figures, joint by joint [N m].
    pub estimate: [Vec<f64>; 2],
}

/// The methods: the paper's five, then what it lacks.
pub const METHODS: [&str; 9] = [
    "torque",
    "gravity",
    "gravity-friction",
    "inverse-dynamics",
    "disturbance-observer",
    "inverse-dynamics-same-bandwidth",
    "momentum-observer",
    "kalman",
    "sliding-mode",
];

/// Mean errors of the paper's table 4, five methods, joints 1 and 2 [N m], and their percentages.
pub fn published(load: Load) -> [[[f64; 2]; 2]; 5] {
    match load {
        Load::Payload => [
            [[0.159, 0.101], [121.0, 62.0]],
            [[0.131, 0.073], [99.0, 44.0]],
            [[0.100, 0.048], [76.0, 29.0]],
            [[0.066, 0.044], [50.0, 27.0]],
            [[0.044, 0.040], [33.0, 25.0]],
        ],
        Load::ForceSensor => [
            [[0.327, 0.271], [78.0, 132.0]],
            [[0.291, 0.072], [69.0, 35.0]],
            [[0.286, 0.051], [68.0, 25.0]],
            [[0.093, 0.041], [22.0, 20.0]],
            [[0.051, 0.037], [12.0, 18.0]],
        ],
    }
}

/// The simulated wrist, and the model of its builders.
#[derive(Debug, Clone)]
pub struct Wrists {
    /// Column C, made feasible.
    pub real: Model,
    /// Column A.
    pub cad: Model,
}

impl Wrists {
    /// Both.
    ///
    /// # Errors
    /// None, unless the files of the program are damaged.
    pub fn new() -> Result<Self, BadInput> {
        let text = include_str!("../../../robots/wrist_repaired.urdf");
        Ok(Self { real: Model::from_urdf(text, "wrist_repaired")?, cad: Model::builtin("wrist")? })
    }
}

/// Friction of the real wrist: the curves of column C, bristles under them, `drift` times as much.
pub(super) fn friction(drift: f64) -> Vec<TrueFriction> {
    let first = |v: f64| match (v > 0.0, v.abs() < 0.5) {
        (true, true) => 0.1310 + 0.0271 * v,
        (true, false) => 0.1463 - 0.0035 * v,
        (false, true) => 0.1367,
        (false, false) => 0.1399 + 0.0063 * v,
    };
    let second = |v: f64| if v > 0.0 { 0.0708 - 0.0016 * v } else { 0.0775 + 0.0015 * v };
    let joint = |curve: super::plant::Curve, stiffness, damping, ripple| TrueFriction {
        curve,
        stiffness,
        damping,
        scale: 1.0 + drift,
        ripple,
    };
    vec![joint(Box::new(first), 200.0, 1.0, 0.02), joint(Box::new(second), 60.0, 0.2, 0.02)]
}

fn plant(real: &Model, drift: f64) -> Plant<'_> {
    let imperfections = Imperfections { encoder_step: ENCODER_STEP, torque_error: 0.01, torque_noise: 2e-3 };
    Plant::new(real, friction(drift), imperfections, PERIOD)
}

fn controller() -> Controller {
    Controller { stiffness: vec![25.0, 6.0], damping: vec![1.0, 0.12] }
}

/// Swept sines of section 2.4: 0.38 to 1.22 Hz and 0.48 to 1.62 Hz in 12 s, about where the wrist is used (not published).
fn sweep(t: f64) -> [Vec<f64>; 3] {
    let [mut q, dq, ddq] = sines(t, [(0.35, 0.38, 1.22), (0.3, 0.48, 1.62)]);
    q.iter_mut().for_each(|q| *q += SWEPT_ABOUT);
    [q, dq, ddq]
}

/// Sinusoids of section 3.3, about a posture in which the loads have the paper's ratio of mean torques: both joints at 0.73 rad for the
/// payload (sin² to cos² as .131 to .163), at 0.96 rad for the force sensor (as .42 to .205).
fn tracking(load: Load, t: f64) -> [Vec<f64>; 3] {
    let posture = match load {
        Load::Payload => 0.73,
        Load::ForceSensor => 0.96,
    };
    let [mut q, dq, ddq] = sines(t, [(0.5, 0.35, 0.35), (0.4, 0.5, 0.5)]);
    q.iter_mut().for_each(|q| *q += posture);
    [q, dq, ddq]
}

/// a sin φ(t) with a frequency that goes from one to the other within the trial: coordinates, speeds, accelerations.
fn sines(t: f64, joints: [(f64, f64, f64); 2]) -> [Vec<f64>; 3] {
    let rows = joints.map(|(a, from, to)| {
        let slope = (to - from) / DURATION;
        let (phase, w, dw) = (TAU * (from * t + 0.5 * slope * t * t), TAU * (from + slope * t), TAU * slope);
        let (sin, cos) = phase.sin_cos();
        [a * sin, a * w * cos, a * (dw * cos - w * w * sin)]
    });
    [0, 1, 2].map(|k| rows.iter().map(|row| row[k]).collect())
}

/// A swept sine of a wrist of nominal friction: the trial, and the motion as an identification takes it.
///
/// # Errors
/// None for the sweep here.
pub fn sweep_wrist(wrists: &Wrists, seed: u64) -> Result<(PlantTrial, JointMotion), BadInput> {
    let mut noise = normal(seed, "wrist/sweep");
    let trial = plant(&wrists.real, 0.0).run(&sweep, &controller(), &|_| vec![], DURATION, &mut noise);
    let column = |rows: &[f64], j: usize| -> Vec<f64> { rows.iter().skip(j).step_by(2).copied().collect() };
    let [q, tau] = [&trial.position, &trial.torque].map(|rows| [column(rows, 0), column(rows, 1)]);
    let smoothing = Smoothing { rate: 1.0 / PERIOD, order: 4, cutoff: 15.0 };
    let motion = JointMotion::smoothed([&q, &[], &tau], smoothing)?;
    Ok((trial, motion))
}

/// How a wrist is identified from its sweep.
pub const SWEEP_OPTIONS: BodyOptions<'static> = BodyOptions { terms: &TERMS, width: 0.1, prior: 1.0 };

/// Sweeps a wrist of nominal friction and identifies it from its encoders and drives.
///
/// # Errors
/// Of the identification; none for the sweep here.
pub fn identify_wrist(wrists: &Wrists, seed: u64) -> Result<KnownArm, BadInput> {
    let (trial, motion) = sweep_wrist(wrists, seed)?;
    let fit = identify_bodies(&wrists.cad, &motion, &SWEEP_OPTIONS)?;
    // The line with the least squared residual of the sweep itself, which has no contact.
    let speeds = streamed_speeds(&trial, 2, &LowPass::new(5, 30.0, 1.0 / PERIOD)?);
    let periods = vec![PERIOD; trial.position.len() / 2];
    let left = |known: &KnownArm| -> f64 {
        let mut observer =
            MomentumObserver::new(RigidBody::new(&known.model), known.friction.clone(), &[BANDWIDTH; 2]);
        let rows = estimate(&mut observer, &periods, [&trial.position, &speeds, &trial.torque]);
        // Joint by joint relative to what was identified.
        rows[2 * WARM_UP..].iter().enumerate().map(|(k, x)| (x / known.rms[k % 2]).powi(2)).sum()
    };
    let [first, rest @ ..] = LINES.map(|width| KnownArm::of(&fit, width));
    Ok(rest.into_iter().fold(first, |best, known| if left(&known) < left(&best) { known } else { best }))
}

/// Gain of the disturbance observer with the bandwidth of all, from the inertia along the motion.
fn gain(model: &Model, path: Path) -> Result<ObserverGain, BadInput> {
    let mut data = Data::new(model, 0.0);
    let (mut largest, mut rate, mut inertias) = (0.0_f64, 0.0_f64, vec![0.0_f64; 2]);
    let mut before = [0.0; 4];
    for k in 0..(DURATION / 0.01) as usize {
        let [q, ..] = path(0.01 * k as f64);
        let mut mass = [0.0; 4];
        mass_matrix(model, &mut data, &q, &mut mass);
        // Frobenius' norm: never less than the largest eigenvalue.
        let norm = |m: &[f64]| m.iter().map(|x| x * x).sum::<f64>().sqrt();
        largest = largest.max(norm(&mass));
        for (j, inertia) in inertias.iter_mut().enumerate() {
            *inertia = inertia.max(mass[3 * j]);
        }
        if k > 0 {
            let change: Vec<f64> = mass.iter().zip(&before).map(|(a, b)| (a - b) / 0.01).collect();
            rate = rate.max(norm(&change));
        }
        before = mass;
    }
    ObserverGain::for_bandwidth(BANDWIDTH, &inertias, largest, rate)
}

/// Every method, in the order of [`METHODS`].
fn observers(known: &KnownArm, load: Load) -> Result<Vec<Box<dyn Observer + '_>>, BadInput> {
    let body = || RigidBody::new(&known.model);
    let friction = || known.friction.clone();
    let smoothing = || LowPass::new(5, 30.0, 1.0 / PERIOD);
    let gains = [BANDWIDTH; 2];
    let noise = [
        KalmanNoise { momentum: 1e-4, torque: 5e-4, contact: 1.0 },
        KalmanNoise { momentum: 2e-5, torque: 5e-4, contact: 0.5 },
    ];
    Ok(vec![
        Box::new(StaticResidual::new(body(), friction(), Terms::Torque)),
        Box::new(StaticResidual::new(body(), friction(), Terms::Gravity)),
        Box::new(StaticResidual::new(body(), friction(), Terms::GravityAndFriction)),
        Box::new(FilteredInverseDynamics::new(body(), friction(), smoothing()?)),
        Box::new(DisturbanceObserver::new(body(), friction(), &gain(&known.model, &|t| tracking(load, t))?)),
        Box::new(FilteredInverseDynamics::new(body(), friction(), smoothing()?).at_bandwidth(&gains)),
        Box::new(MomentumObserver::new(body(), friction(), &gains)),
        Box::new(KalmanObserver::new(body(), friction(), &noise)),
        Box::new(SlidingModeObserver::new(body(), friction(), &[3.0, 2.0])),
    ])
}

/// Speeds as an estimator in the loop has them: differences of the encoders through a causal filter, row by row.
pub(super) fn streamed_speeds(trial: &PlantTrial, n: usize, filter: &LowPass) -> Vec<f64> {
    let mut speeds = vec![0.0; trial.position.len()];
    for j in 0..n {
        let mut state = filter.start(0.0);
        let mut before = trial.position[j];
        for k in 0..trial.position.len() / n {
            let now = trial.position[n * k + j];
            speeds[n * k + j] = state.next((now - before) / trial.period);
            before = now;
        }
    }
    speeds
}

/// One trial under a load, with the external torque that it means.
fn loaded_trial(wrists: &Wrists, load: Load, drift: f64, seed: u64) -> Result<PlantTrial, BadInput> {
    let name = format!("wrist/{}/{drift}", load.name());
    let mut noise = normal(seed, &name);
    let real = &wrists.real;
    let path = |t: f64| tracking(load, t);
    match load {
        Load::ForceSensor => {
            let frame = real.frame("payload")?;
            let pull = |force: f64| {
                // Up: against gravity.
                let [x, y, z] = real.gravity().map(|g| -force * g / 9.81);
                move |_: f64| vec![ExternalForce { frame, force: [x, y, z], torque: [0.0; 3] }]
            };
            // The torque is linear in the force: scaled to the paper's means along the path that is meant.
            let probe = Plant::new(real, friction(-1.0 + 1e-9), exact(), 1e-2).run(
                &path,
                &controller(),
                &pull(1.0),
                DURATION,
                &mut || 0.0,
            );
            let mean = probe.external.iter().map(|x| x.abs()).sum::<f64>() / probe.external.len() as f64;
            let force = 0.5 * SENSOR_MEAN / mean;
            Ok(plant(real, drift).run(&path, &controller(), &pull(force), DURATION, &mut noise))
        }
        Load::Payload => {
            let with = real.with_payload("payload", 0.3, [0.0; 3], [0.0; 6])?;
            let mut trial = plant(&with, drift).run(&path, &controller(), &|_| vec![], DURATION, &mut noise);
            trial.external = payload_torques(&with, real, &trial);
            Ok(trial)
        }
    }
}

/// No imperfections.
fn exact() -> Imperfections {
    Imperfections { encoder_step: 0.0, torque_error: 0.0, torque_noise: 0.0 }
}

/// Torques of a payload on the joints (n_samples × n) [N m]: those that the arm needs without it, less those
/// with it.
fn payload_torques(with: &Model, without: &Model, trial: &PlantTrial) -> Vec<f64> {
    let n = without.n_joints();
    let n_samples = trial.true_position.len() / n;
    let (mut loaded, mut bare) = (Data::new(with, 0.0), Data::new(without, 0.0));
    let [mut a, mut b, mut ddq] = [0; 3].map(|_| vec![0.0; n]);
    let mut external = Vec::with_capacity(n * n_samples);
    for k in 0..n_samples {
        let (low, high) = (k.saturating_sub(1), (k + 1).min(n_samples - 1));
        for j in 0..n {
            let speed = |k: usize| trial.true_velocity[n * k + j];
            ddq[j] = (speed(high) - speed(low)) / ((high - low) as f64 * trial.period);
        }
        let row = n * k..n * (k + 1);
        let (q, dq) = (&trial.true_position[row.clone()], &trial.true_velocity[row]);
        inverse_dynamics(with, &mut loaded, [q, dq, &ddq], &[], &mut a);
        inverse_dynamics(without, &mut bare, [q, dq, &ddq], &[], &mut b);
        external.extend(b.iter().zip(&a).map(|(b, a)| b - a));
    }
    external
}

/// All methods on one trial.
///
/// # Errors
/// A gain that the motion does not allow; none here.
pub fn wrist_cell(
    wrists: &Wrists,
    known: &KnownArm,
    (load, drift, seed): (Load, f64, u64),
) -> Result<WristCell, BadInput> {
    let n = wrists.cad.n_joints();
    let trial = loaded_trial(wrists, load, drift, seed)?;
    let speeds = streamed_speeds(&trial, n, &LowPass::new(5, 30.0, 1.0 / PERIOD)?);
    let n_samples = trial.position.len() / n;
    let periods = vec![PERIOD; n_samples];
    let counted = |rows: &[f64], j: usize| -> f64 {
        rows.iter().skip(n * WARM_UP + j).step_by(n).map(|x| x.abs()).sum::<f64>()
            / (n_samples - WARM_UP) as f64
    };
    let mean_truth_n_m = [0, 1].map(|j| counted(&trial.external, j));
    let shown = |rows: &[f64]| [0, 1].map(|j| rows.iter().skip(j).step_by(n * DECIMATION).copied().collect());
    let methods = METHODS.iter().zip(observers(known, load)?).map(|(name, mut observer)| {
        let rows = estimate(observer.as_mut(), &periods, [&trial.position, &speeds, &trial.torque]);
        let errors: Vec<f64> = rows.iter().zip(&trial.external).map(|(a, b)| a - b).collect();
        let error_n_m = [0, 1].map(|j| counted(&errors, j));
        WristMethod {
            name: (*name).to_owned(),
            error_n_m,
            error_percent: [0, 1].map(|j| 100.0 * error_n_m[j] / mean_truth_n_m[j]),
            estimate: shown(&rows),
        }
    });
    Ok(WristCell {
        load,
        drift,
        seed,
        identified_rms_n_m: [known.rms[0], known.rms[1]],
        mean_truth_n_m,
        methods: methods.collect(),
        time_s: (0..n_samples).step_by(DECIMATION).map(|k| k as f64 * PERIOD).collect(),
        truth: shown(&trial.external),
    })
}

/// The paper's simulations without friction: noise of one step of the encoders, its offsets of the model, the mass of the second link.
///
/// # Errors
/// None for the motion here.
pub fn simulated_errors(wrists: &Wrists) -> Result<[ErrorComparison; 3], BadInput> {
    let model = &wrists.real;
    let path = |t: f64| tracking(Load::Payload, t);
    let disturbance = |t: f64| vec![(TAU * 0.25 * t).sin(), 0.4 * (TAU * 0.4 * t).sin()];
    let scenario =
        Scenario { model, path: &path, disturbance: &disturbance, duration: DURATION, period: PERIOD };
    let chosen = gain(model, &path)?;
    // "A large observer gain, to minimise the filtering effect."
    let fast = ObserverGain { y: chosen.y.iter().map(|y| 20.0 * y).collect(), ..chosen.clone() };
    let mut direction = vec![[0.0; 10]; 2];
    direction[1] = by_mass(&model.joints()[1].inertia);
    Ok([
        scenario.with_noise(ENCODER_STEP, &chosen, 1)?,
        scenario.with_wrong_model([0.015, 0.15, 0.15], &fast),
        scenario.sensitivity(&direction, &chosen),
    ])
}
