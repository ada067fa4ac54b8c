//! Motion and torques of all joints, smoothed for a regression.

use hysteron_actuator::filter::LowPass;
use hysteron_base::BadInput;

use crate::{ArmRecording, JointQuantityKind};

/// Row by row (n_samples × n_joints): coordinates, speeds, accelerations, torques.
#[derive(Debug, Clone, PartialEq)]
pub struct JointMotion {
    /// Joints n.
    pub n_joints: usize,
    /// Time from sample to sample [s].
    pub period: f64,
    /// Coordinates [rad] or [m].
    pub q: Vec<f64>,
    /// Speeds.
    pub dq: Vec<f64>,
    /// Accelerations.
    pub ddq: Vec<f64>,
    /// Torques [N m] or forces [N].
    pub tau: Vec<f64>,
}

/// A zero-phase Butterworth low pass, and how many samples are kept of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Smoothing {
    /// Samples per second [Hz].
    pub rate: f64,
    /// Order of the filter, which passes forwards and backwards.
    pub order: usize,
    /// Half of the power of one pass is left here [Hz].
    pub cutoff: f64,
}

impl JointMotion {
    /// Number of samples.
    pub fn n_samples(&self) -> usize {
        self.q.len() / self.n_joints.max(1)
    }

    /// From measured coordinates and torques, column by column: all are smoothed alike, speeds (where not measured) and
    /// accelerations are central differences of the smooth ones. At both ends, where a smoothed value rests on a reflection rather
    /// than on measurements, two periods of the cutoff are left out.
    ///
    /// # Errors
    /// `BadInput` for columns of different lengths, a joint that never moves, a number that is not finite, a torque that rests at
    /// its largest value (saturation), or a filter that cannot be.
    pub fn smoothed([q, dq, tau]: [&[Vec<f64>]; 3], smoothing: Smoothing) -> Result<Self, BadInput> {
        let n_joints = q.len();
        let n = q.first().map_or(0, Vec::len);
        let columns = [("q", q), ("dq", dq), ("tau", tau)];
        for (what, columns) in columns.iter().filter(|(what, columns)| *what != "dq" || !columns.is_empty()) {
            if columns.len() != n_joints || columns.iter().any(|column| column.len() != n) {
                return Err(BadInput::new(*what, format!("{n_joints} columns of {n} samples"), "others"));
            }
            for (j, column) in columns.iter().enumerate() {
                if let Some(k) = column.iter().position(|x| !x.is_finite()) {
                    let place = format!("{what}_{}, sample {}", j + 1, k + 1);
                    return Err(BadInput::new(place, "a finite number", column[k].to_string()));
                }
            }
        }
        for (j, (q, tau)) in q.iter().zip(tau).enumerate() {
            check_moves(&format!("q_{}", j + 1), q)?;
            check_moves(&format!("tau_{}", j + 1), tau)?;
            check_saturation(&format!("tau_{}", j + 1), tau)?;
        }
        let filter = LowPass::new(smoothing.order, smoothing.cutoff, smoothing.rate)?;
        let smooth = |columns: &[Vec<f64>]| -> Vec<Vec<f64>> {
            columns.iter().map(|x| filter.zero_phase(x)).collect()
        };
        let differences = |columns: &[Vec<f64>]| -> Vec<Vec<f64>> {
            columns.iter().map(|x| central_differences(x, smoothing.rate)).collect()
        };
        let (q, tau) = (smooth(q), smooth(tau));
        let dq = if dq.is_empty() { differences(&q) } else { smooth(dq) };
        let ddq = differences(&dq);
        let rows = |columns: &[Vec<f64>]| {
            (0..n).flat_map(|k| columns.iter().map(move |column| column[k])).collect::<Vec<f64>>()
        };
        let period = 1.0 / smoothing.rate;
        let motion = Self { n_joints, period, q: rows(&q), dq: rows(&dq), ddq: rows(&ddq), tau: rows(&tau) };
        let end = (2.0 * smoothing.rate / smoothing.cutoff).ceil() as usize;
        if n < 4 * end {
            let expected = format!(
                "at least {} samples for a cutoff of {} Hz",
                4 * end,
                hysteron_base::number::shown(smoothing.cutoff)
            );
            return Err(BadInput::new("motion", expected, n.to_string()));
        }
        Ok(motion.part(end..n - end))
    }

    /// The joints of a recording; see [`Self::smoothed`]. Where it has no torques, these are currents times `torque_constants`
    /// [N m/A], one for each joint; none where it has.
    ///
    /// # Errors
    /// Coordinates or torques that the recording lacks; another number of constants than joints; a torque constant that is not a
    /// finite number; those of [`Self::smoothed`].
    pub fn of_recording(
        recorded: &ArmRecording,
        torque_constants: &[f64],
        order: usize,
        cutoff: f64,
    ) -> Result<Self, BadInput> {
        let owned = |columns: Vec<&[f64]>| columns.into_iter().map(<[f64]>::to_vec).collect::<Vec<_>>();
        let q = owned(recorded.require(JointQuantityKind::Position)?);
        let tau = torques(recorded, torque_constants)?;
        let dq = recorded.require(JointQuantityKind::Velocity).map(owned).unwrap_or_default();
        let time = recorded.time;
        let span = time.last().unwrap_or(&0.0) - time.first().unwrap_or(&0.0);
        let rate = time.len().saturating_sub(1) as f64 / span;
        let uneven = time.windows(2).position(|pair| ((pair[1] - pair[0]) * rate - 1.0).abs() > UNEVEN);
        if let Some(k) = uneven {
            let found = format!(
                "{} s after {} s",
                hysteron_base::number::shown(time[k + 1]),
                hysteron_base::number::shown(time[k])
            );
            return Err(BadInput::new(
                "time_s",
                format!("one rate, here {rate:.1} samples per second"),
                found,
            )
            .hint("`hysteron import --rate HZ` resamples a file"));
        }
        Self::smoothed([&q, &dq, &tau], Smoothing { rate, order, cutoff })
    }

    /// The samples of `range`.
    pub fn part(&self, range: std::ops::Range<usize>) -> Self {
        let range = range.start * self.n_joints..range.end * self.n_joints;
        let part = |rows: &[f64]| rows[range.clone()].to_vec();
        Self {
            n_joints: self.n_joints,
            period: self.period,
            q: part(&self.q),
            dq: part(&self.dq),
            ddq: part(&self.ddq),
            tau: part(&self.tau),
        }
    }

    /// Appends the samples of another motion of the same arm.
    pub fn extend(&mut self, other: &Self) {
        for (all, more) in [&mut self.q, &mut self.dq, &mut self.ddq, &mut self.tau]
            .into_iter()
            .zip([&other.q, &other.dq, &other.ddq, &other.tau])
        {
            all.extend_from_slice(more);
        }
    }
}

/// Root mean square of what `torques` leave of every joint's torque in these motions [N m].
pub(super) fn rms_left<'a>(
    motions: impl IntoIterator<Item = &'a JointMotion>,
    n_joints: usize,
    torques: impl Fn(&JointMotion) -> Vec<f64>,
) -> Vec<f64> {
    let (mut squares, mut samples) = (vec![0.0; n_joints], 0);
    for motion in motions {
        for (k, (found, measured)) in torques(motion).iter().zip(&motion.tau).enumerate() {
            squares[k % n_joints] += (found - measured).powi(2);
        }
        samples += motion.n_samples();
    }
    squares.iter().map(|square| (square / samples as f64).sqrt()).collect()
}

/// Torques of a recording, measured or from currents.
fn torques(recorded: &ArmRecording, torque_constants: &[f64]) -> Result<Vec<Vec<f64>>, BadInput> {
    let of = |columns: Vec<&[f64]>, scale: &dyn Fn(usize) -> f64| -> Vec<Vec<f64>> {
        let scaled = |(j, column): (usize, &[f64])| column.iter().map(|x| scale(j) * x).collect();
        columns.into_iter().enumerate().map(scaled).collect()
    };
    if torque_constants.is_empty() {
        let has_currents = recorded.require(JointQuantityKind::Current).is_ok();
        return match recorded.require(JointQuantityKind::Torque) {
            Ok(columns) => Ok(of(columns, &|_| 1.0)),
            Err(bad) if has_currents => {
                Err(bad.hint("it has currents: give the torque constants, one for each joint"))
            }
            Err(bad) => Err(bad),
        };
    }
    let currents = recorded.require(JointQuantityKind::Current)?;
    if torque_constants.len() != currents.len()
        || torque_constants.iter().any(|k| !k.is_finite() || *k == 0.0)
    {
        let expected = format!("{} finite numbers other than 0, one for each joint", currents.len());
        return Err(BadInput::new("torque constants", expected, format!("{torque_constants:?}")));
    }
    for (j, column) in currents.iter().enumerate() {
        let largest = column.iter().fold(0.0, |most: f64, i| most.max(i.abs()));
        if largest > MAX_CURRENT {
            let found = format!("{largest} A");
            return Err(BadInput::new(
                format!("current_{}_a", j + 1),
                format!("below {MAX_CURRENT} A"),
                found,
            )
            .hint("is it in mA? divide it by 1000, or name its column current_k_ma on import"));
        }
    }
    Ok(of(currents, &|j| torque_constants[j]))
}

/// Current that no joint of an arm takes [A]: what is above is in mA.
const MAX_CURRENT: f64 = 200.0;
/// Part of a period by which a step of time may differ from the others: a dropped sample bends every derivative [-].
const UNEVEN: f64 = 0.05;

fn check_moves(name: &str, column: &[f64]) -> Result<(), BadInput> {
    let (low, high) = column.iter().fold((f64::MAX, f64::MIN), |(a, b), x| (a.min(*x), b.max(*x)));
    if column.len() < 10 || high <= low {
        let found = format!("{} samples from {low} to {high}", column.len());
        return Err(BadInput::new(name, "10 or more samples that are not all alike", found)
            .hint("was the joint locked, or is the channel not connected? leave it out or record it anew"));
    }
    Ok(())
}

/// Share of all samples at the very same extreme from which on a torque counts as saturated.
const SATURATED: f64 = 0.02;

fn check_saturation(name: &str, column: &[f64]) -> Result<(), BadInput> {
    let high = column.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    let at = column.iter().filter(|x| x.abs() >= high * (1.0 - 1e-12)).count();
    if at > 10 && at as f64 > SATURATED * column.len() as f64 {
        let found = format!("{at} of {} samples at its largest size {high}", column.len());
        let hint = "the drive was at its limit there: record slower motions, or a lighter load";
        return Err(BadInput::new(name, "a torque that is not saturated", found).hint(hint));
    }
    Ok(())
}

fn central_differences(x: &[f64], rate: f64) -> Vec<f64> {
    let n = x.len();
    let at = |k: usize| {
        let (a, b) = (k.saturating_sub(1), (k + 1).min(n - 1));
        (x[b] - x[a]) * rate / (b - a) as f64
    };
    (0..n).map(at).collect()
}
