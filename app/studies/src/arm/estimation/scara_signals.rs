//! Signals of the SCARA's momentum observer: under gains and noise, before and after the filter, and in a collision.
//!
//! # Reference
//! Wan et al. (2026), sections 2.4.2 to 2.4.3 and 3.5: figures 5, 6, 7 and 17.

use std::f64::consts::TAU;

use hysteron_actuator::filter::{LowPass, Specification, median_of};
use hysteron_base::BadInput;
use serde::{Deserialize, Serialize};

use super::normal;
use super::plant::{Imperfections, Plant, PlantTrial, TrueFriction};
use super::scara::{GAINS, Methods, PERIOD, controller, differences, lead, plant, tip_force};
use hysteron_arm_dynamics::Model;
use hysteron_arm_estimation::observer::{FrictionModel, MomentumObserver, RigidBody, estimate};

/// Gains of figure 5a, joint 1's of the paper among them [1/s].
const SHOWN_GAINS: [f64; 4] = [10.0, 30.0, 50.0, 100.0];
/// Noise of figure 5b [N m]; figure 5a has the middle one.
const SHOWN_NOISE: [f64; 3] = [0.5, 1.0, 2.0];
/// Gain of figure 5b [1/s].
const GAIN: f64 = 50.0;
/// The low-pass filter of section 2.4.3.
const FILTER: Specification = Specification { pass: 60.0, pass_db: -4.0, stop: 150.0, stop_db: -20.0 };
/// Half of the window of the median, which is five samples wide.
const MEDIAN_HALF: usize = 2;

/// Curves over time.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Curves {
    /// [s].
    pub time_s: Vec<f64>,
    /// Names of the curves, and their values joint by joint [N m].
    pub curves: Vec<(String, [Vec<f64>; 2])>,
}

/// Signals of the observer.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct SignalCell {
    /// Seed of all draws.
    pub seed: u64,
    /// A force from 1 to 2 s by observers of four gains, without friction: figure 5a.
    pub gains: Curves,
    /// The same under three sizes of noise: figure 5b.
    pub noise: Curves,
    /// Led by the hand, before and after the filter: figures 6 and 7.
    pub filtered: Curves,
    /// A collision by every method: figure 17.
    pub collision: Curves,
}

/// All of them.
///
/// # Errors
/// None, unless the files of the program are damaged.
pub fn signal_cell(methods: &Methods, seed: u64) -> Result<SignalCell, BadInput> {
    let model = Model::builtin("scara")?;
    let step = |noise: f64| stepped(&model, noise, seed);
    let of_gain = |trial: &PlantTrial, gain: f64| {
        let mut observer = MomentumObserver::new(RigidBody::new(&model), FrictionModel::none(2), &[gain; 2]);
        let periods = vec![PERIOD; trial.position.len() / 2];
        by_joint(&estimate(&mut observer, &periods, [&trial.position, &differences(trial), &trial.torque]))
    };
    let trial = step(SHOWN_NOISE[1])?;
    let mut gains = Curves::of(&trial);
    gains.curves.extend(SHOWN_GAINS.map(|gain| (format!("K = {gain} 1/s"), of_gain(&trial, gain))));
    let mut noise = Curves::of(&trial);
    for deviation in SHOWN_NOISE {
        noise.curves.push((format!("{deviation} N m"), of_gain(&step(deviation)?, GAIN)));
    }
    Ok(SignalCell {
        seed,
        gains,
        noise,
        filtered: filtered(&model, methods, seed)?,
        collision: collision(&model, methods, seed)?,
    })
}

impl Curves {
    /// The truth of a trial alone.
    fn of(trial: &PlantTrial) -> Self {
        let n = trial.position.len() / 2;
        Self {
            time_s: (0..n).map(|k| k as f64 * PERIOD).collect(),
            curves: vec![("true".to_owned(), by_joint(&trial.external))],
        }
    }
}

/// Rows of two joints, joint by joint.
fn by_joint(rows: &[f64]) -> [Vec<f64>; 2] {
    [0, 1].map(|j| rows.iter().skip(j).step_by(2).copied().collect())
}

/// An arm without friction under a force of 25 N at the tip from 1 to 2 s.
fn stepped(model: &Model, torque_noise: f64, seed: u64) -> Result<PlantTrial, BadInput> {
    let tip = model.frame("tip")?;
    let none =
        || TrueFriction { curve: Box::new(|_| 1e-9), stiffness: 1.0, damping: 0.0, scale: 1.0, ripple: 0.0 };
    let imperfections = Imperfections { encoder_step: 0.0, torque_error: 0.0, torque_noise };
    let plant = Plant::new(model, vec![none(), none()], imperfections, PERIOD);
    let loading = |t: f64| tip_force(tip, t, if (1.0..2.0).contains(&t) { 25.0 } else { 0.0 });
    Ok(plant.run(&lead, &controller(), &loading, 3.0, &mut normal(seed, "scara/step")))
}

/// Led by the hand: the observer with ANFIS's friction, raw, and through median and zero-phase low pass.
fn filtered(model: &Model, methods: &Methods, seed: u64) -> Result<Curves, BadInput> {
    let tip = model.frame("tip")?;
    let loading = |t: f64| tip_force(tip, t, 20.0 * (TAU * 0.3 * t).sin());
    let trial = plant(model).run(&lead, &controller(), &loading, 6.0, &mut normal(seed, "scara/filtered"));
    let filter = LowPass::meeting(FILTER, 1.0 / PERIOD)?;
    let mut curves = Curves::of(&trial);
    if let Some((_, rows)) = methods.estimates(&trial).into_iter().next() {
        let raw = by_joint(&rows);
        let smooth = raw.clone().map(|signal| filter.zero_phase(&median_of(&signal, MEDIAN_HALF)));
        curves.curves.extend([("raw".to_owned(), raw), ("filtered".to_owned(), smooth)]);
    }
    Ok(curves)
}

/// A collision of a quarter of a second, which rises and falls within 10 ms, 4 s after the start.
fn collision(model: &Model, methods: &Methods, seed: u64) -> Result<Curves, BadInput> {
    let tip = model.frame("tip")?;
    let share = |t: f64| ((t - 4.0) / 0.01).clamp(0.0, 1.0) * ((4.25 - t) / 0.01).clamp(0.0, 1.0);
    let loading = |t: f64| tip_force(tip, t, 25.0 * share(t));
    let trial = plant(model).run(&lead, &controller(), &loading, 5.0, &mut normal(seed, "scara/collision"));
    let mut curves = Curves::of(&trial);
    let estimates = methods.estimates(&trial).into_iter().filter(|(name, _)| *name != "none");
    curves.curves.extend(estimates.map(|(name, rows)| (name.to_owned(), by_joint(&rows))));
    let alpha = GAINS.map(|gain| 1.0 / (1.0 + gain * PERIOD));
    let mut state = [0.0; 2];
    let perfect: Vec<f64> = trial
        .external
        .iter()
        .enumerate()
        .map(|(k, truth)| {
            let j = k % 2;
            state[j] = alpha[j] * state[j] + (1.0 - alpha[j]) * truth;
            state[j]
        })
        .collect();
    curves.curves.push(("perfect model".to_owned(), by_joint(&perfect)));
    // From half a second before the contact to half a second after it.
    let shown = (3.5 / PERIOD) as usize..(4.75 / PERIOD) as usize;
    curves.time_s = curves.time_s[shown.clone()].to_vec();
    for (_, joints) in &mut curves.curves {
        joints.iter_mut().for_each(|values| *values = values[shown.clone()].to_vec());
    }
    Ok(curves)
}
