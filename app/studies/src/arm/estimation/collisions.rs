//! Collisions of the simulated SCARA: delays, false alarms, which joint, thresholds.
//!
//! # Reference
//! Wan et al. (2026), section 3.5: table 3, figure 17.

use std::ops::Range;

use hysteron_base::BadInput;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::normal;
use super::scara::{GAINS, Methods, OBSERVERS, PERIOD, Sums, controller, lead, plant, tip_force};
use hysteron_arm_dynamics::Model;
use hysteron_arm_estimation::detection::{
    Assessment, Band, Cusum, FreeMotion, Test, Truth, assess, logarithmic, roc,
};

/// How one observer detects collisions.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct DetectionRow {
    /// Name of [`OBSERVERS`].
    pub method: String,
    /// Samples by which an alarm is later than that of an observer with a perfect model at the same threshold, mean and largest.
    pub excess_delay_samples: [f64; 2],
    /// Samples from the first truth above the threshold to the alarm, mean.
    pub delay_samples: f64,
    /// Error of the largest torque of a collision, mean over collisions, joint by joint [N m].
    pub peak_error_n_m: [f64; 2],
    /// Root mean square error during collisions [N m].
    pub rmse_n_m: [f64; 2],
    /// Largest error during collisions [N m].
    pub max_n_m: [f64; 2],
    /// Share of collisions whose outermost loaded joint was named.
    pub right_joint: f64,
    /// Of the band test at its lowest threshold with at most one false alarm an hour.
    pub band: Assessment,
    /// Of the cumulated sums, likewise.
    pub cusum: Assessment,
    /// Thresholds of the band fitted to motion without contact, as fitted.
    pub learned: Assessment,
    /// Receiver operating characteristic of the band test.
    pub roc: Vec<Assessment>,
}

/// Collisions during motion: table 3 and the receiver operating characteristic.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct CollisionCell {
    /// Seed of all draws.
    pub seed: u64,
    /// Collisions.
    pub n_contacts: usize,
    /// Time without contact [h].
    pub free_hours: f64,
    /// The observers.
    pub rows: Vec<DetectionRow>,
}

/// Thresholds of the receiver operating characteristic, in multiples of what was largest without contact.
pub const THRESHOLDS: (f64, f64, usize) = (0.2, 5.0, 41);
/// Most that the tables allow [1/h].
const FALSE_ALARMS_PER_HOUR: f64 = 1.0;
/// An alarm goes off below this share of its threshold.
const RELEASE: f64 = 0.7;
/// Duration of one stretch of motion [s]; each has its own noise.
const STRETCH: f64 = 300.0;
/// Time from one collision to the next [s].
const APART: f64 = 6.0;
/// How long a collision lasts [s].
const TOUCH: f64 = 0.25;
/// Rise of the force at the beginning and the end of a collision [s].
const RISE: f64 = 0.01;

/// A collision: when it begins [s] and its force [N].
#[derive(Debug, Clone, Copy)]
struct Collision {
    start: f64,
    force: f64,
}

impl Collision {
    /// Share of its force at `t`.
    fn share(&self, t: f64) -> f64 {
        ((t - self.start) / RISE).clamp(0.0, 1.0) * ((self.start + TOUCH - t) / RISE).clamp(0.0, 1.0)
    }
}

/// Collisions while the arm moves, and motion without: `n_stretches` of 300 s each.
///
/// # Errors
/// None, unless the files of the program are damaged.
pub fn collision_cell(methods: &Methods, n_stretches: usize, seed: u64) -> Result<CollisionCell, BadInput> {
    let model = Model::builtin("scara")?;
    let tip = model.frame("tip")?;
    let plant = plant(&model);
    let free = {
        let mut noise = normal(seed, "scara/free");
        plant.run(&lead, &controller(), &|_| vec![], STRETCH, &mut noise)
    };
    let learned: Vec<(FreeMotion, Vec<f64>)> = methods
        .estimates(&free)
        .into_iter()
        .map(|(_, rows)| (FreeMotion::learn(&rows[2 * WARM_UP..], 2), rows[2 * WARM_UP..].to_vec()))
        .collect();
    let mut tallies: Vec<Tally> = learned.iter().map(|_| Tally::default()).collect();
    let mut truth = Truth { contacts: vec![], settling: (0.5 / PERIOD) as usize, period: PERIOD };
    let mut ideal = Vec::new();
    for k in 0..n_stretches {
        let mut noise = normal(seed, &format!("scara/collisions/{k}"));
        let collisions: Vec<Collision> = (1..(STRETCH / APART) as usize)
            .map(|c| {
                let start = APART * (c as f64 + 0.1 * noise());
                let size = 25.0 + 5.0 * noise();
                Collision { start, force: if noise() > 0.0 { size } else { -size } }
            })
            .collect();
        let at = |t: f64| collisions[((t / APART).round() as usize).clamp(1, collisions.len()) - 1];
        let loading = |t: f64| {
            let collision = at(t);
            tip_force(tip, t, collision.force * collision.share(t))
        };
        let trial = plant.run(&lead, &controller(), &loading, STRETCH, &mut noise);
        let offset = ideal.len() / 2;
        let sample = |t: f64| (t / PERIOD).ceil() as usize;
        let contacts: Vec<Range<usize>> =
            collisions.iter().map(|c| sample(c.start)..sample(c.start + TOUCH + RISE)).collect();
        for ((tally, (_, rows)), (free, free_rows)) in
            tallies.iter_mut().zip(methods.estimates(&trial)).zip(&learned)
        {
            tally.add(&rows, &trial.external, &contacts, (free, free_rows));
        }
        ideal.extend(first_order(&trial.external));
        truth.contacts.extend(contacts.into_iter().map(|c| c.start + offset..c.end + offset));
    }
    let rows = OBSERVERS.iter().zip(tallies).zip(&learned);
    let rows: Vec<DetectionRow> =
        rows.map(|((name, tally), (free, _))| tally.row(name, free, &ideal, &truth)).collect();
    let n_samples = ideal.len() / 2;
    let touched: usize = truth.contacts.iter().map(|c| c.len() + truth.settling).sum();
    Ok(CollisionCell {
        seed,
        n_contacts: truth.contacts.len(),
        free_hours: (n_samples - touched) as f64 * PERIOD / 3600.0,
        rows,
    })
}

/// Samples at the beginning of a stretch in which observers settle.
const WARM_UP: usize = 400;

/// Estimate of a first-order observer with a perfect model (rows of two joints) [N m].
fn first_order(truth: &[f64]) -> Vec<f64> {
    let mut state = [0.0; 2];
    let mut rows = Vec::with_capacity(truth.len());
    for (k, truth) in truth.iter().enumerate() {
        let alpha = 1.0 / (1.0 + GAINS[k % 2] * PERIOD);
        state[k % 2] = alpha * state[k % 2] + (1.0 - alpha) * truth;
        rows.push(state[k % 2]);
    }
    rows
}

/// Values of both tests and errors in collisions, stretch after stretch.
#[derive(Default)]
struct Tally {
    band: Vec<f64>,
    cusum: Vec<f64>,
    in_contact: Sums,
    peaks: [f64; 2],
    n_contacts: f64,
    right_joint: f64,
}

/// Slack of the cumulated sums, in standard deviations.
const SLACK: f64 = 1.0;

impl Tally {
    fn add(
        &mut self,
        rows: &[f64],
        truth: &[f64],
        contacts: &[Range<usize>],
        (free, free_rows): (&FreeMotion, &[f64]),
    ) {
        let mut band = Band::learned(free, 1.0);
        let mut cusum = Cusum::learned(free.clone(), SLACK, free_rows, 1.0);
        let mut joints = Vec::with_capacity(rows.len() / 2);
        for (k, row) in rows.chunks(2).enumerate() {
            // The start of a stretch is no motion: the arm is set going within a sample.
            let is_warm = k >= WARM_UP;
            let [a, b] = [band.update(row), cusum.update(row)];
            self.band.push(if is_warm { a } else { 0.0 });
            self.cusum.push(if is_warm { b } else { 0.0 });
            joints.push(band.joint());
        }
        for contact in contacts {
            let part = 2 * contact.start..2 * contact.end;
            self.in_contact.add(&rows[part.clone()], &truth[part.clone()]);
            for j in 0..2 {
                let largest = |rows: &[f64]| {
                    rows[part.clone()].iter().skip(j).step_by(2).fold(0.0, |m: f64, x| m.max(x.abs()))
                };
                self.peaks[j] += (largest(rows) - largest(truth)).abs();
            }
            self.n_contacts += 1.0;
            let named = joints[contact.clone()].iter().flatten().max();
            self.right_joint += f64::from(u8::from(named == Some(&1)));
        }
    }

    fn row(self, name: &str, free: &FreeMotion, ideal: &[f64], truth: &Truth) -> DetectionRow {
        let (least, most, n) = THRESHOLDS;
        let thresholds = logarithmic(least, most, n);
        let curve = roc(&self.band, &thresholds, RELEASE, truth);
        let sums = roc(&self.cusum, &thresholds, RELEASE, truth);
        // The soonest alarms of those that are false once an hour at most; where none is, the fewest false ones.
        let best = |curve: &[Assessment]| {
            let too_many = curve.iter().rposition(|at| at.false_alarms_per_hour > FALSE_ALARMS_PER_HOUR);
            let found = curve.get(too_many.map_or(0, |k| k + 1));
            found.or(curve.last()).cloned().unwrap_or_else(|| assess(&[], 1.0, RELEASE, truth))
        };
        let band = best(&curve);
        let (excess_delay_samples, delay_samples) = excess(&self.band, band.threshold, free, ideal, truth);
        DetectionRow {
            method: name.to_owned(),
            excess_delay_samples,
            delay_samples,
            peak_error_n_m: self.peaks.map(|p| p / self.n_contacts),
            rmse_n_m: self.in_contact.rmse(),
            max_n_m: self.in_contact.extremes[1],
            right_joint: self.right_joint / self.n_contacts,
            cusum: best(&sums),
            learned: assess(&self.band, 1.0, RELEASE, truth),
            band,
            roc: curve,
        }
    }
}

/// By how many samples alarms come later than with a perfect model at the same thresholds, mean and largest; and than the contact.
fn excess(
    values: &[f64],
    threshold: f64,
    free: &FreeMotion,
    ideal: &[f64],
    truth: &Truth,
) -> ([f64; 2], f64) {
    let mut perfect = Band::new(&[0.0; 2], &[threshold * free.largest[0], threshold * free.largest[1]]);
    let (mut sum, mut largest, mut delay, mut n) = (0.0, f64::NEG_INFINITY, 0.0, 0.0);
    for contact in &truth.contacts {
        let of_ideal = contact.clone().find(|k| perfect.update(&ideal[2 * k..2 * k + 2]) > 1.0);
        let of_test = contact.clone().find(|k| values[*k] > threshold);
        if let (Some(ideal), Some(test)) = (of_ideal, of_test) {
            let late = test as f64 - ideal as f64;
            sum += late;
            largest = f64::max(largest, late);
            delay += (test - contact.start) as f64;
            n += 1.0;
        }
    }
    ([sum / n, largest], delay / n)
}
