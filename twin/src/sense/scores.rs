//! How good estimates are where the truth is known, next to simpler ones.

use std::borrow::Cow;

use hysteron_actuator::{CatalogueDrive, LoadModel, SteadyMotion};
use nalgebra::Vector3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::fit::RecordingObservations;
use super::observer::{Observation, SenseSample};
use super::sensor::{ForceSensor, SensedSample};
use crate::Result;

/// Speed of the tendons below which the robot rests [m/s], over a window [s].
const AT_REST: f64 = 2e-4;
const WINDOW: f64 = 0.1;
/// After a contact has begun its force is evaluated so much later, and a contact found so late counts as missed [s].
const SETTLED: f64 = 0.3;
const AT_ONCE: f64 = 0.1;
/// Tolerances of an accurate force: absolute [N] and relative to the true force [-]; of its direction [rad].
const NEAR: (f64, f64) = (0.03, 0.15);
const ALIGNED: f64 = 15.0 / 180.0 * std::f64::consts::PI;
/// Servo whose armature the momentum observer takes, and its gain [1/s].
const SERVO: &str = "xl430-w250";
const MOMENTUM_GAIN: f64 = 20.0;

/// The truth of a recording, where it is known.
#[derive(Debug, Clone, Default)]
pub struct SensingTruth {
    /// Force on the tip, sample by sample [N].
    pub force: Option<Vec<Vector3<f64>>>,
    /// Tensions of a simulated robot (n_primary × n_samples) [N].
    pub tensions: Option<Vec<Vec<f64>>>,
}

impl SensingTruth {
    /// Whether the tip was pushed with a known force.
    pub fn is_pushed(&self) -> bool {
        self.force.as_ref().is_some_and(|force| force.iter().any(|force| force.norm() > 0.0))
    }
}

/// Errors of tensions over their root mean square [-].
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct TensionScore {
    /// Method of the estimate.
    pub method: Cow<'static, str>,
    /// All samples.
    pub all: f64,
    /// While the tendons move.
    pub moving: f64,
    /// While they rest.
    pub resting: f64,
}

/// Errors of the force on the tip.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct ForceScore {
    /// Method of the estimate.
    pub method: Cow<'static, str>,
    /// Which samples.
    pub samples: Cow<'static, str>,
    /// How many.
    pub n: usize,
    /// Root mean square of the error's norm [N].
    pub rms_n: f64,
    /// Median of the error's norm [N].
    pub median_n: f64,
    /// Share within 30 mN or 15 % [-].
    pub near: f64,
    /// Share whose direction is off by 15° at most [-].
    pub aligned: f64,
}

/// How contacts were found.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct ContactScore {
    /// Contacts.
    pub contacts: usize,
    /// Share found within 100 ms [-], of all and of those that were not preceded by a contact that had not been given up.
    pub found_at_once: f64,
    /// Share of contacts above 0.15 N found within 100 ms [-].
    pub strong_found_at_once: f64,
    /// Alarms while there was no contact and had been none for a second, an hour [1/h].
    pub false_alarms_per_hour: f64,
    /// Time without contact [s].
    pub free_s: f64,
    /// Share of it in which a contact was detected [-].
    pub claimed: f64,
}

/// Scores of all estimates.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct SensingScores {
    /// Where tensions are known.
    pub tensions: Vec<TensionScore>,
    /// Samples with a known force during pushes.
    pub forces: Vec<ForceScore>,
    /// See `forces`; samples without pushes too.
    pub contacts: Option<ContactScore>,
}

/// True where the tendons have hardly moved for a while.
fn resting(observed: &RecordingObservations, period: f64) -> Vec<bool> {
    let n = (WINDOW / period).round() as usize;
    let samples = &observed.samples;
    let pulled =
        |i: usize| samples[i.saturating_sub(n) + 1..=i].iter().map(|sample| sample.path).sum::<f64>();
    (0..samples.len()).map(|i| i > n && pulled(i) < AT_REST * WINDOW).collect()
}

/// Compares estimates with the truth, and simpler estimates from the samples of the same recording with it.
///
/// # Errors
/// `BadInput` of a servo of the sensor that cannot be.
pub fn score<'a>(
    truth: &SensingTruth,
    samples: impl Fn(usize) -> SenseSample<'a>,
    observed: &RecordingObservations,
    sensed: &[SensedSample],
    sensor: &ForceSensor,
) -> Result<SensingScores> {
    let samples: Vec<SenseSample> = (0..sensed.len()).map(samples).collect();
    let period = sensor.period_s;
    let rest = resting(observed, period);
    let load = sensor.servo.map(|servo| servo.model()).transpose()?;
    let tensions = match &truth.tensions {
        Some(truth) => tension_scores(truth, &rest, &samples, observed, sensed, (sensor, load.as_ref()))?,
        None => Vec::new(),
    };
    let Some(force) = &truth.force else {
        return Ok(SensingScores { tensions, forces: Vec::new(), contacts: None });
    };
    let own: Vec<Vector3<f64>> = sensed.iter().map(|sensed| sensed.tip.force).collect();
    let direct: Vec<Vector3<f64>> = observed
        .samples
        .iter()
        .map(|sample| {
            let response = sample.response / sensor.stiffness_scale;
            // The axis of the body hardly yields.
            let inverse = response.pseudo_inverse(0.1 * response.norm());
            inverse.ok().zip(sample.gap).map_or_else(Vector3::zeros, |(inverse, gap)| inverse * gap)
        })
        .collect();
    let settled = settled(force, period);
    let mut forces = Vec::new();
    if truth.is_pushed() {
        for (method, estimate) in [
            ("sensor", &own),
            ("tip and twin alone", &direct),
            ("no force", &vec![Vector3::zeros(); own.len()]),
        ] {
            for (samples, is_resting) in [("moving", false), ("at rest", true)] {
                let chosen: Vec<usize> =
                    (0..force.len()).filter(|&i| settled[i] && rest[i] == is_resting).collect();
                forces.extend(force_score(method, samples, &chosen, force, estimate));
            }
        }
    }
    let contacts = Some(contact_score(force, sensed, period));
    Ok(SensingScores { tensions, forces, contacts })
}

/// Tensions by the sensor, by the twin, and by simpler methods from the loads of the servos, where these are known.
fn tension_scores(
    truth: &[Vec<f64>],
    rest: &[bool],
    samples: &[SenseSample],
    observed: &RecordingObservations,
    sensed: &[SensedSample],
    (sensor, load): (&ForceSensor, Option<&LoadModel>),
) -> Result<Vec<TensionScore>> {
    let own = |i: usize, j: usize| sensed[i].tensions[j].0;
    let twin = |i: usize, j: usize| observed.samples[i].tensions[j];
    let scaled = |i: usize, j: usize| sensor.tension.force_scale * twin(i, j);
    let mut scores = vec![
        tension_score("servos and twin", truth, rest, &own),
        tension_score("twin alone", truth, rest, &twin),
        tension_score("twin, forces scaled", truth, rest, &scaled),
    ];
    if let Some(load) = load {
        let (alone, held) = (raw_loads(samples, load), held_loads(observed, load));
        let momentum = momentum_loads(samples, load, sensor.period_s)?;
        scores.push(tension_score("load alone, friction known", truth, rest, &|i, j| held[i][j]));
        scores.push(tension_score("load alone", truth, rest, &|i, j| alone[i][j]));
        scores.push(tension_score("momentum observer of the servo", truth, rest, &|i, j| momentum[i][j]));
    }
    Ok(scores)
}

fn tension_score(
    method: &'static str,
    truth: &[Vec<f64>],
    rest: &[bool],
    estimate: &dyn Fn(usize, usize) -> f64,
) -> TensionScore {
    let relative = |counts: &dyn Fn(usize) -> bool| {
        let (mut error, mut size) = (0.0, 0.0);
        for (j, tension) in truth.iter().enumerate() {
            for (i, tension) in tension.iter().enumerate().filter(|(i, _)| counts(*i)) {
                error += (estimate(i, j) - tension).powi(2);
                size += tension * tension;
            }
        }
        (error / size).sqrt()
    };
    TensionScore {
        method: method.into(),
        all: relative(&|_| true),
        moving: relative(&|i| !rest[i]),
        resting: relative(&|i| rest[i]),
    }
}

/// Load over radius, as if nothing rubbed.
fn raw_loads(samples: &[SenseSample], load: &LoadModel) -> Vec<Vec<f64>> {
    let of = |sample: &SenseSample| {
        let loads = sample.loads.unwrap_or_default();
        loads.iter().map(|value| (load.stall_torque * value / load.radius).max(0.0)).collect()
    };
    samples.iter().map(of).collect()
}

/// Generalized momentum of each servo, I ω: what motor and friction leave of its change is the tendon's,
///
/// r' = K (τ - τ_f(ω) - r) - K I ω'.
fn momentum_loads(samples: &[SenseSample], load: &LoadModel, period: f64) -> Result<Vec<Vec<f64>>> {
    let inertia = CatalogueDrive::named(SERVO)?.drive.gear.armature;
    let n = samples.first().map_or(0, |sample| sample.strokes.len());
    let (mut momentum, mut residual) = (vec![0.0; n], vec![0.0; n]);
    let of = |i: usize| {
        let (now, before) = (samples[i], samples[i.saturating_sub(SteadyMotion::SPAN)]);
        let (Some(angles), Some(last), Some(loads)) = (now.angles, before.angles, now.loads) else {
            return vec![0.0; n];
        };
        for j in 0..n {
            let velocity = (angles[j] - last[j]) / (SteadyMotion::SPAN as f64 * period);
            let torque = load.radius * load.tension(loads[j], velocity);
            let change = inertia * velocity - momentum[j];
            momentum[j] += change;
            residual[j] += MOMENTUM_GAIN * ((torque - residual[j]) * period - change);
        }
        residual.iter().map(|residual| (residual / load.radius).max(0.0)).collect()
    };
    Ok((0..samples.len()).map(of).collect())
}

/// Load less friction in steady motion, and kept in between.
fn held_loads(observed: &RecordingObservations, load: &LoadModel) -> Vec<Vec<f64>> {
    let mut held = vec![0.0; observed.samples.first().map_or(0, |sample| sample.tensions.len())];
    let of = |sample: &Observation| {
        for (held, steady) in held.iter_mut().zip(&sample.steady) {
            if let Some(steady) = steady {
                *held = load.tension(steady.load, steady.velocity).max(0.0);
            }
        }
        held.clone()
    };
    observed.samples.iter().map(of).collect()
}

/// Samples of a contact that has lasted.
fn settled(force: &[Vector3<f64>], period: f64) -> Vec<bool> {
    let n = (SETTLED / period).round() as usize;
    let mut since = 0;
    force
        .iter()
        .map(|force| {
            since = if force.norm() > 0.0 { since + 1 } else { 0 };
            since > n
        })
        .collect()
}

fn force_score(
    method: &'static str,
    samples: &'static str,
    chosen: &[usize],
    truth: &[Vector3<f64>],
    estimate: &[Vector3<f64>],
) -> Option<ForceScore> {
    let n = chosen.len();
    let mut errors: Vec<f64> = chosen.iter().map(|&i| (estimate[i] - truth[i]).norm()).collect();
    let share =
        |counts: &dyn Fn(usize) -> bool| chosen.iter().filter(|i| counts(**i)).count() as f64 / n as f64;
    let near = share(&|i| (estimate[i] - truth[i]).norm() <= NEAR.0.max(NEAR.1 * truth[i].norm()));
    let aligned = share(&|i| estimate[i].norm() > 0.0 && estimate[i].angle(&truth[i]) <= ALIGNED);
    let rms_n = (errors.iter().map(|error| error * error).sum::<f64>() / n as f64).sqrt();
    errors.sort_by(f64::total_cmp);
    let median_n = *errors.get(n / 2)?;
    Some(ForceScore { method: method.into(), samples: samples.into(), n, rms_n, median_n, near, aligned })
}

fn contact_score(force: &[Vector3<f64>], sensed: &[SensedSample], period: f64) -> ContactScore {
    let is_on = |i: usize| force[i].norm() > 0.0;
    let second = (1.0 / period).round() as usize;
    let late = (AT_ONCE / period).round() as usize;
    let starts: Vec<usize> = (1..force.len()).filter(|&i| is_on(i) && !is_on(i - 1)).collect();
    let found = |&&i: &&usize| (i..(i + late).min(force.len())).any(|k| sensed[k].tip.is_contact);
    let strong: Vec<usize> =
        starts.iter().copied().filter(|&i| force[(i + late).min(force.len() - 1)].norm() > 0.15).collect();
    let share = |of: &[usize]| of.iter().filter(found).count() as f64 / of.len().max(1) as f64;
    let is_free = |i: usize| (i.saturating_sub(second)..=i).all(|k| !is_on(k));
    let alarm = |i: &usize| sensed[*i].tip.is_contact && !sensed[*i - 1].tip.is_contact && is_free(*i);
    let free = (0..force.len()).filter(|&i| !is_on(i));
    let free_s = free.clone().count() as f64 * period;
    let claimed = free.filter(|&i| sensed[i].tip.is_contact).count() as f64 * period / free_s;
    ContactScore {
        contacts: starts.len(),
        found_at_once: share(&starts),
        strong_found_at_once: share(&strong),
        false_alarms_per_hour: (1..force.len()).filter(alarm).count() as f64 / free_s * 3600.0,
        free_s,
        claimed,
    }
}
