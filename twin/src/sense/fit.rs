//! Learning a sensor from recordings without contact, and from pushes of known force where there are some.

use hysteron_actuator::{LoadModel, SteadyMotion};
use hysteron_base::BadInput;
use nalgebra::Vector3;

use super::observer::{Observation, Steady};
use super::sensor::{ForceSensor, ServoLoad};
use super::tension::TensionErrors;
use super::tip_force::{TipForceErrors, TipForceFilter, TipSample};

type Check<T> = std::result::Result<T, BadInput>;

/// Observations of a recording: robot compared with twin.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordingObservations {
    /// For messages.
    pub name: String,
    /// Sample by sample.
    pub samples: Vec<Observation>,
}

/// A recording in which the force on the tip was known.
#[derive(Debug, Clone, PartialEq)]
pub struct KnownForce {
    /// Observations.
    pub observed: RecordingObservations,
    /// Force on the tip, sample by sample [N].
    pub force: Vec<Vector3<f64>>,
}

/// Time differences at which changes of the gap are compared [s].
const LAGS: [f64; 7] = [0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0];
/// Path of the tendons below which they rest [m].
const AT_REST: f64 = 2e-5;
/// Samples on either side in which a tendon must be slack to count as slack.
const SLACK: usize = 15;
/// Fewest pairs of samples, and known changes of force, that a parameter is fitted to.
const MIN_PAIRS: usize = 200;
const MIN_JUMPS: usize = 5;
/// Change of a known force that counts as a jump [N]; its effect is a mean over this time after it less one over a time before [s].
const JUMP: f64 = 0.03;
const AFTER_JUMP: [f64; 2] = [0.08, 0.18];
const BEFORE_JUMP: f64 = 0.08;
/// Smallest error of a tip that is accepted [m].
const FINEST: f64 = 5e-6;
/// Standard error of the response where no push of known force was recorded [-]: creep and sticking friction stiffen the tip.
const UNKNOWN_RESPONSE: f64 = 0.4;
/// Time over which changes along and across the tip's motion are compared, and over which that motion is taken [s].
const CHANGE: f64 = 0.08;
const DIRECTION: f64 = 0.15;
/// False alarms in contact-free motion: one an hour, of all classes of speed together.
const SECONDS_PER_ALARM: f64 = 3600.0;
/// Largest values of the statistic are taken in blocks of this time [s]; this part of them is its tail.
const BLOCK: f64 = 0.5;
const TAIL: f64 = 0.2;

/// Learns a sensor for samples of `period` [s] from recordings `free` of contact; `servo`: stall torque [N m] and radius of the pulleys
/// [m], where loads were recorded; `known`: recordings with pushes of known force.
///
/// # Errors
/// Too little motion or rest, or tendons that never go slack.
pub fn fit_sensor(
    free: &[RecordingObservations],
    known: &[KnownForce],
    servo: Option<(f64, f64)>,
    period: f64,
) -> Check<ForceSensor> {
    let load = servo.map(|(stall_torque, radius)| friction(free, stall_torque, radius)).transpose()?;
    let tension = tension_errors(free, load.as_ref(), period);
    let (stiffness_scale, response) = match stiffness(known, period) {
        Some(found) => found,
        None => (tension.force_scale, UNKNOWN_RESPONSE),
    };
    let mut tip = TipForceErrors { response, ..tip_errors(free, period)? };
    tip.thresholds = thresholds(free, &tip, stiffness_scale, period)?;
    let servo = load.as_ref().map(ServoLoad::of);
    let sensor = ForceSensor { period_s: period, servo, tension, stiffness_scale, tip };
    sensor.check()?;
    Ok(sensor)
}

/// Friction of the servos, from steady motion of tendons that are slack in the twin.
fn friction(free: &[RecordingObservations], stall_torque: f64, radius: f64) -> Check<LoadModel> {
    let (mut velocity, mut load) = (Vec::new(), Vec::new());
    for RecordingObservations { samples, .. } in free {
        for i in SLACK..samples.len().saturating_sub(SLACK) {
            for (j, steady) in samples[i].steady.iter().enumerate() {
                let Some(steady) = steady else { continue };
                let near = &samples[i - SLACK..=i + SLACK];
                if near.iter().all(|sample| sample.tensions[j] <= 0.0) {
                    velocity.push(steady.velocity);
                    load.push(steady.load);
                }
            }
        }
    }
    LoadModel::identify(stall_torque, radius, &velocity, &load)
}

/// Scale of the twin's forces, and errors of its tensions and of the loads.
fn tension_errors(free: &[RecordingObservations], load: Option<&LoadModel>, period: f64) -> TensionErrors {
    // Without loads nothing is known but that twins err.
    let unknown = TensionErrors { force_scale: 1.0, walk_sqrt_n: 0.5, model_n: 5.0, load_n: 1.0 };
    let Some(load) = load else { return unknown };
    let from_load = |steady: &Steady| load.tension(steady.load, steady.velocity);
    let pairs = || {
        let samples = free.iter().flat_map(|observed| &observed.samples);
        samples
            .flat_map(|sample| sample.steady.iter().flatten().map(|steady| (from_load(steady), steady.twin)))
    };
    let square: f64 = pairs().map(|(_, twin)| twin * twin).sum();
    if square == 0.0 {
        return unknown;
    }
    let force_scale = pairs().map(|(tension, twin)| tension * twin).sum::<f64>() / square;
    let error = |steady: &Steady| from_load(steady) - force_scale * steady.twin;
    let mean_square = |values: &[f64]| values.iter().map(|x| x * x).sum::<f64>() / values.len().max(1) as f64;
    let model_n =
        mean_square(&pairs().map(|(tension, twin)| tension - force_scale * twin).collect::<Vec<_>>()).sqrt();
    // Changes from one sample to the next are the loads' noise; those within a second are the twin's.
    let (mut next, mut later, mut changed) = (Vec::new(), Vec::new(), 0.0);
    let second = (1.0 / period).round() as usize;
    for RecordingObservations { samples, .. } in free {
        for j in 0..samples.first().map_or(0, |sample| sample.tensions.len()) {
            let at = |i: usize| samples.get(i).and_then(|sample| sample.steady[j].as_ref()).map(error);
            for i in 0..samples.len() {
                let Some(now) = at(i) else { continue };
                next.extend(at(i + 1).map(|then| then - now));
                if let Some(then) = at(i + second) {
                    later.push(then - now);
                    let steps = samples[i..=i + second].windows(2);
                    changed += steps
                        .map(|pair| force_scale * (pair[1].tensions[j] - pair[0].tensions[j]).abs())
                        .sum::<f64>();
                }
            }
        }
    }
    let noise = mean_square(&next) / 2.0;
    let grown = (mean_square(&later) - 2.0 * noise).max(0.0) * later.len() as f64;
    let walk_sqrt_n = if changed > 0.0 { (grown / changed).sqrt() } else { unknown.walk_sqrt_n };
    // Neighbours share their samples: they differ by a part of their noise, and count as one together.
    let alike = SteadyMotion::SPAN as f64;
    TensionErrors { force_scale, walk_sqrt_n, model_n, load_n: (noise * alike * alike).sqrt().max(1e-3) }
}

/// Stiffness of the tip over the twin's and the standard error of the response, from jumps of known forces.
fn stiffness(known: &[KnownForce], period: f64) -> Option<(f64, f64)> {
    let samples_of = |time: f64| (time / period).round() as usize;
    let ([first, last], n_before) = (AFTER_JUMP.map(samples_of), samples_of(BEFORE_JUMP).max(1));
    let mut jumps: Vec<(Vector3<f64>, Vector3<f64>)> = Vec::new();
    for KnownForce { observed: RecordingObservations { samples, .. }, force } in known {
        let mean = |range: std::ops::Range<usize>| {
            let n = range.len() as f64;
            Some(samples[range].iter().map(|sample| sample.gap).sum::<Option<Vector3<f64>>>()? / n)
        };
        let mut i = n_before;
        while i + last < samples.len().min(force.len()) {
            let change = force[i + first] - force[i - 1];
            let is_new = (force[i] - force[i - 1]).norm() > 0.0;
            // It stays what it has become.
            if is_new
                && change.norm() > JUMP
                && (force[i + last] - force[i + first]).norm() < 0.05 * change.norm()
            {
                if let (Some(before), Some(after)) = (mean(i - n_before..i), mean(i + first..i + last)) {
                    jumps.push((samples[i - 1].response * change, after - before));
                }
                i += last;
            }
            i += 1;
        }
    }
    if jumps.len() < MIN_JUMPS {
        return None;
    }
    let square: f64 = jumps.iter().map(|(from_load, _)| from_load.norm_squared()).sum();
    let share = jumps.iter().map(|(predicted, measured)| predicted.dot(measured)).sum::<f64>() / square;
    let left =
        |(predicted, measured): &(Vector3<f64>, Vector3<f64>)| (measured - share * predicted).norm_squared();
    let total: f64 = jumps.iter().map(|(_, measured)| measured.norm_squared()).sum();
    let response = (jumps.iter().map(left).sum::<f64>() / total).sqrt();
    (share > 0.0).then_some((1.0 / share, response))
}

/// Mean squares of changes of the gap, by lag and path.
struct Changes {
    /// Path [m], change along x, y, z squared [m²], lag [s].
    pairs: Vec<(f64, [f64; 3], f64)>,
}

impl Changes {
    fn of(free: &[RecordingObservations], period: f64) -> Self {
        let mut pairs = Vec::new();
        for RecordingObservations { samples, .. } in free {
            let mut path = 0.0;
            let paths: Vec<f64> = samples
                .iter()
                .map(|sample| {
                    path += sample.path;
                    path
                })
                .collect();
            for lag in LAGS {
                let n = (lag / period).round() as usize;
                for i in 0..samples.len().saturating_sub(n) {
                    let (Some(before), Some(after)) = (samples[i].gap, samples[i + n].gap) else { continue };
                    let change = (after - before).map(|x| x * x);
                    pairs.push((paths[i + n] - paths[i], [change.x, change.y, change.z], lag));
                }
            }
        }
        Self { pairs }
    }

    /// Means over the pairs that `counts` chooses, and how many they are.
    fn mean(&self, counts: impl Fn(f64, f64) -> bool) -> ([f64; 3], usize) {
        let (mut sum, mut n) = ([0.0; 3], 0);
        for (_, square, _) in self.pairs.iter().filter(|(path, _, lag)| counts(*path, *lag)) {
            (0..3).for_each(|c| sum[c] += square[c]);
            n += 1;
        }
        (sum.map(|sum| sum / f64::from(n.max(1))), n as usize)
    }
}

/// Errors of the tip without contact; the threshold is still missing.
fn tip_errors(free: &[RecordingObservations], period: f64) -> Check<TipForceErrors> {
    let changes = Changes::of(free, period);
    let at_rest = |lag: f64| changes.mean(|path, of| path < AT_REST && of == lag);
    let ((short, n_short), (long, n_long)) = (at_rest(LAGS[0]), at_rest(LAGS[3]));
    if n_short.min(n_long) < MIN_PAIRS {
        let expected = format!("at least {MIN_PAIRS} samples at rest, half a second long");
        return Err(BadInput::new("recordings without contact", expected, n_long.to_string())
            .hint("record motions with holds between them"));
    }
    let creep = [0, 1, 2].map(|c| ((long[c] - short[c]).max(0.0) / (LAGS[3] - LAGS[0])).sqrt().max(FINEST));
    let noise =
        [0, 1, 2].map(|c| ((short[c] - creep[c] * creep[c] * LAGS[0]).max(0.0) / 2.0).sqrt().max(FINEST));
    // By path, in steps of a factor of two.
    let edges: Vec<f64> = (0..10).map(|k| 5e-5 * f64::from(2u32.pow(k))).collect();
    let bins: Vec<(f64, [f64; 3], usize)> = edges
        .windows(2)
        .filter_map(|edge| {
            let (mean, n) = changes.mean(|path, _| (edge[0]..edge[1]).contains(&path));
            (n >= MIN_PAIRS).then_some(((edge[0] * edge[1]).sqrt(), mean, n))
        })
        .collect();
    if bins.len() < 3 {
        return Err(BadInput::new(
            "recordings without contact",
            "tendons that move by several millimetres",
            "hardly any motion",
        ));
    }
    // 2 m² (1 - e^(-path/length)) plus the effect of noise.
    let fit = |length: f64| {
        let grown = |path: f64| 2.0 * (1.0 - (-path / length).exp());
        let mut error = 0.0;
        let model = [0, 1, 2].map(|c| {
            let excess = |mean: &[f64; 3]| mean[c] - 2.0 * noise[c] * noise[c];
            // Relative errors of the bins are alike.
            let weigh = |mean: &[f64; 3]| 1.0 / mean[c].powi(2);
            let up: f64 = bins.iter().map(|(path, mean, _)| weigh(mean) * grown(*path) * excess(mean)).sum();
            let down: f64 = bins.iter().map(|(path, mean, _)| weigh(mean) * grown(*path).powi(2)).sum();
            let square = (up / down).max(FINEST * FINEST);
            error += bins
                .iter()
                .map(|(path, mean, _)| weigh(mean) * (excess(mean) - square * grown(*path)).powi(2))
                .sum::<f64>();
            square.sqrt()
        });
        (error, length, model)
    };
    let lengths = (0..40).map(|k| 2e-4 * 1.12f64.powi(k));
    let (_, length_m, model_m) =
        lengths.map(fit).min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or_else(|| fit(2e-3));
    let offset = |c: usize| {
        let of_one = |observed: &RecordingObservations| {
            let gaps: Vec<f64> = observed.samples.iter().filter_map(|s| s.gap.map(|gap| gap[c])).collect();
            (gaps.iter().sum::<f64>() / gaps.len().max(1) as f64).powi(2)
        };
        (free.iter().map(of_one).sum::<f64>() / free.len().max(1) as f64).sqrt().max(noise[c])
    };
    let [walk_along_sqrt_m, walk_across_sqrt_m] = random_walks(free, &noise, period);
    Ok(TipForceErrors {
        noise_m: noise,
        model_m,
        offset_m: [0, 1, 2].map(offset),
        length_m,
        walk_along_sqrt_m,
        walk_across_sqrt_m,
        creep_m_per_sqrt_s: creep,
        response: 0.0,
        thresholds: [f64::MAX; 4],
    })
}

/// Random walks of the gap over the path, along the tip's motion and across it [√m].
fn random_walks(free: &[RecordingObservations], noise: &[f64; 3], period: f64) -> [f64; 2] {
    let [n_change, n_direction] = [CHANGE, DIRECTION].map(|time| (time / period).round() as usize);
    let noise = noise.iter().map(|noise| noise * noise).sum::<f64>() / 3.0;
    let (mut grown, mut pulled) = ([0.0; 2], 0.0);
    for RecordingObservations { samples, .. } in free {
        for i in n_direction..samples.len() {
            let path: f64 = samples[i + 1 - n_change..=i].iter().map(|sample| sample.path).sum();
            let (before, after) = (samples[i - n_change].gap, samples[i].gap);
            let motion = samples[i].free_tip - samples[i - n_direction].free_tip;
            let (Some(before), Some(after), Some(direction)) = (before, after, motion.try_normalize(1e-9))
            else {
                continue;
            };
            if path > AT_REST {
                let along = (after - before).dot(&direction).powi(2);
                grown[0] += along - 2.0 * noise;
                grown[1] += 0.5 * ((after - before).norm_squared() - along) - 2.0 * noise;
                pulled += path;
            }
        }
    }
    grown.map(|grown| (grown / pulled.max(AT_REST)).max(FINEST).sqrt())
}

/// Statistics that motion without contact passes once an hour, by classes of speed: their largest values fall off exponentially.
fn thresholds(
    free: &[RecordingObservations],
    errors: &TipForceErrors,
    stiffness_scale: f64,
    period: f64,
) -> Check<[f64; 4]> {
    let n_block = (BLOCK / period).round() as usize;
    let mut largest: [Vec<f64>; 4] = Default::default();
    let mut n_samples = 0;
    for RecordingObservations { samples, .. } in free {
        n_samples += samples.len();
        let mut filter = TipForceFilter::new(*errors, period);
        for block in samples.chunks(n_block) {
            let mut found = [0.0f64; 4];
            for sample in block {
                let statistic = filter.step(&TipSample::of(sample, stiffness_scale)).statistic;
                let class = filter.class();
                found[class] = found[class].max(statistic);
            }
            let found = largest.iter_mut().zip(found).filter(|(_, found)| *found > 0.0);
            found.for_each(|(largest, found)| largest.push(found));
        }
    }
    let alarms = n_samples as f64 * period / SECONDS_PER_ALARM / largest.len() as f64;
    let once = |largest: &mut Vec<f64>| -> Option<f64> {
        largest.sort_by(f64::total_cmp);
        let n_tail = (TAIL * largest.len() as f64) as usize;
        let tail = &largest[largest.len() - n_tail..];
        let (first, last) = (tail.first()?, tail.last()?);
        let excess = tail.iter().map(|x| x - first).sum::<f64>() / n_tail as f64;
        Some(last.max(first + excess * (n_tail as f64 / alarms).ln()))
    };
    // A class that the robot was hardly in is like its neighbour.
    let mut found = largest.map(|mut largest| once(&mut largest));
    for k in (0..3).rev() {
        found[k] = found[k].or(found[k + 1]);
    }
    for k in 1..4 {
        found[k] = found[k].or(found[k - 1]);
    }
    match found {
        [Some(a), Some(b), Some(c), Some(d)] => Ok([a, b, c, d]),
        _ => Err(BadInput::new("recordings without contact", "several seconds", "less").hint("record more")),
    }
}
