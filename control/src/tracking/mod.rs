//! How closely a tip followed a target: the metrics of the CoReAct paper, section V-B, and additional ones.
//!
//! Everything is measured in the plane (x, y), and only on the curve itself: neither rest nor the way to the curve
//! count. A recording of several laps has one polygon for each.

mod closed;
mod curve;
mod overlap;
mod repeats;
mod timing;

#[cfg(test)]
mod tests;

use crate::TargetPath;
use crate::path::PathSpan;
use hysteron_base::{BadInput, Recording};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::ops::RangeInclusive;

pub use closed::frechet_closed;
pub use curve::{PlanarPoint, chamfer, distances, frechet, hausdorff, nearest};
pub use overlap::iou;
pub use repeats::{Repeatability, repeatability};
pub use timing::{Timed, aligned_rmse, lag};

/// Points of the target, at equal distances along its curve, that are compared.
const TARGET_POINTS: f64 = 2000.0;
/// Rounding of a time, far below a sample [s].
const ROUNDING: f64 = 1e-6;
/// Most pairs of a sample of the target and one of the recording: some ten seconds of comparing.
const MAX_PAIRS: usize = 2_000_000_000;

/// Which samples of a recording are the curve.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CurvePart {
    /// Those at the times of the target's curve: the recording begins when the target does.
    AtTheSameTimes,
    /// All of them: the recording holds the curve and nothing else, at any speed.
    Whole,
}

/// From where a recorded tip is measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TipOrigin {
    /// From the origin of the recording's frame, as the robot's own, in which the tip rests on the axis.
    Frame,
    /// From where the tip was at rest: its mean over the target's rest at the beginning.
    Rest,
}

/// A recorded tip, brought to a target's frame, times and laps.
#[derive(Debug, Clone, PartialEq)]
pub struct TrackedTip {
    /// Times since the beginning (n) [s].
    pub time: Vec<f64>,
    /// Where the tip was (n) [m], without samples that were not measured.
    pub points: Vec<PlanarPoint>,
    /// Samples of each lap.
    pub laps: Vec<RangeInclusive<usize>>,
    part: CurvePart,
}

impl TrackedTip {
    /// The tip of a recording of this target.
    ///
    /// # Errors
    /// `BadInput` if the recording has no `tip_x_m` and `tip_y_m`, if it ends before the target's curve does, or if
    /// a lap has fewer than three measured samples.
    pub fn new(
        target: &TargetPath,
        recording: &Recording,
        part: CurvePart,
        origin: TipOrigin,
    ) -> Result<Self, BadInput> {
        let (x, y) = (recording.require("tip_x_m")?, recording.require("tip_y_m")?);
        let (first, span) = (recording.time()[0], PathSpan::of(recording)?);
        let start = first + span.begins;
        let is_path = |i: &usize| {
            let after = recording.time()[*i] - first;
            part == CurvePart::AtTheSameTimes
                || (span.begins - ROUNDING..=span.ends + ROUNDING).contains(&after)
        };
        let measured: Vec<usize> = (0..x.len()).filter(|i| !recording.gap()[*i]).filter(is_path).collect();
        let time: Vec<f64> = measured.iter().map(|i| recording.time()[*i] - start).collect();
        let mut points: Vec<PlanarPoint> = measured.iter().map(|i| [x[*i], y[*i]]).collect();
        if origin == TipOrigin::Rest {
            let rest = target.time(target.rest().end - 1);
            let before = time.partition_point(|time| *time < -ROUNDING).min(points.len().saturating_sub(1));
            let n = time.partition_point(|time| *time <= rest).max(before + 1).min(points.len());
            let resting = &points[before.min(n)..n];
            let sum = resting.iter().fold([0.0; 2], |sum, p| [sum[0] + p[0], sum[1] + p[1]]);
            let mean = sum.map(|sum| sum / resting.len().max(1) as f64);
            points.iter_mut().for_each(|p| *p = [0, 1].map(|c| p[c] - mean[c]));
        }
        let laps = match part {
            CurvePart::AtTheSameTimes => at_times(target, &time, span.ends - span.begins)?,
            CurvePart::Whole => evenly(target.laps().count(), time.len()),
        };
        if let Some(lap) = laps.iter().find(|lap| (*lap).clone().count() < 3) {
            let found = format!("{} of them", lap.clone().count());
            return Err(BadInput::new("recording", "three measured samples or more in every lap", found));
        }
        let tracked = Self { time, points, laps, part };
        let (n_goal, n) = (target.curve().count(), tracked.curve().len());
        if n_goal.saturating_mul(n) > MAX_PAIRS {
            let expected = format!("at most {} samples for a target of {n_goal}", MAX_PAIRS / n_goal);
            let bad = BadInput::new("recording", expected, n.to_string());
            return Err(bad.hint("each is compared with all of the target; a lower rate is enough"));
        }
        Ok(tracked)
    }

    /// Where the tip was on the curve (n) [m].
    pub fn curve(&self) -> &[PlanarPoint] {
        let last = self.laps.len() - 1;
        &self.points[*self.laps[0].start()..=*self.laps[last].end()]
    }
}

/// Samples between the times at which the target's laps begin and end, of a path of `recorded` seconds.
fn at_times(
    target: &TargetPath,
    time: &[f64],
    recorded: f64,
) -> Result<Vec<RangeInclusive<usize>>, BadInput> {
    let end = target.time(*target.curve().end());
    if recorded < end - 1.0 / target.rate_hz - ROUNDING {
        return Err(BadInput::new(
            "recording",
            format!("at least {end:.2} s, when the curve of target {} ends", target.name),
            format!("{recorded:.2} s"),
        )
        .hint("--whole where the recording holds the curve and nothing else: scores of its geometry alone"));
    }
    let lap = |lap: RangeInclusive<usize>| {
        let first = time.partition_point(|t| *t < target.time(*lap.start()) - ROUNDING);
        let after = time.partition_point(|t| *t <= target.time(*lap.end()) + ROUNDING);
        first..=after.saturating_sub(1)
    };
    Ok(target.laps().map(lap).collect())
}

/// `n` samples in `n_laps` equal parts; the last of one is the first of the next.
fn evenly(n_laps: usize, n: usize) -> Vec<RangeInclusive<usize>> {
    let bound = |lap: usize| lap * (n.max(1) - 1) / n_laps;
    (0..n_laps).map(|lap| bound(lap)..=bound(lap + 1)).collect()
}

/// How closely a path followed its target. Lengths in the plane (x, y).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct TrackingScore {
    /// Mean of the RMSE along x and along y from the points of the target to the nearest of the path (eqs. 21, 22) [m].
    pub rmse_m: f64,
    /// Mean over x and y of that RMSE over the target's range along the axis (eq. 19) [-]; none where the target is
    /// straight along an axis.
    pub nrmse: Option<f64>,
    /// The two RMSE [m].
    pub rmse_axes_m: [f64; 2],
    /// Polygon IoU, mean over the laps [-]; none where the target is open.
    pub iou: Option<f64>,
    /// Symmetric Chamfer distance [m].
    pub chamfer_m: f64,
    /// Hausdorff distance [m].
    pub hausdorff_m: f64,
    /// Discrete Fréchet distance, samples of the target against those of the path [m]; of closed targets the smallest over all
    /// beginnings.
    pub frechet_m: f64,
    /// Root mean square distance at the same times [m]; none where times do not compare.
    pub aligned_rmse_m: Option<f64>,
    /// By how much the path comes late [s]; none where times do not compare.
    pub lag_s: Option<f64>,
    /// Samples of the path that count.
    pub samples: usize,
}

/// Measures a path against its target.
///
/// # Reference
/// CoReAct paper, section V-B c. Γ* are 2000 points at equal distances along one lap of the target, Γ is the line
/// through the samples. The paper's NRMSE is that of its eq. 19, per axis over the target's range; averaging both
/// axes gives the digits of its tables II and III.
pub fn score(target: &TargetPath, tracked: &TrackedTip) -> TrackingScore {
    let goal: Vec<PlanarPoint> = target_line(target);
    let path = tracked.curve();
    let pairs = goal.iter().map(|p| (*p, nearest(*p, path)));
    let sums = pairs.fold([0.0; 2], |sum, (p, q)| [0, 1].map(|c| sum[c] + (p[c] - q[c]).powi(2)));
    let rmse_axes_m = sums.map(|sum| (sum / goal.len() as f64).sqrt());
    let range = [0, 1].map(|c| {
        let values = || goal.iter().map(move |p| p[c]);
        values().fold(f64::NEG_INFINITY, f64::max) - values().fold(f64::INFINITY, f64::min)
    });
    let has_range = range.iter().all(|range| *range > 1e-9);
    let samples: Vec<PlanarPoint> = target.curve().map(|i| plane(target.points()[i])).collect();
    let (aligned_rmse_m, lag_s) = match tracked.part {
        CurvePart::AtTheSameTimes => over_time(target, &samples, tracked),
        CurvePart::Whole => (None, None),
    };
    TrackingScore {
        rmse_m: 0.5 * (rmse_axes_m[0] + rmse_axes_m[1]),
        nrmse: has_range.then(|| 0.5 * (rmse_axes_m[0] / range[0] + rmse_axes_m[1] / range[1])),
        rmse_axes_m,
        iou: mean_iou(target, &goal, tracked),
        chamfer_m: chamfer(&goal, path),
        hausdorff_m: hausdorff(&goal, path),
        frechet_m: if target.outline.is_closed() {
            frechet_closed(&samples, path)
        } else {
            frechet(&samples, path)
        },
        aligned_rmse_m,
        lag_s,
        samples: path.len(),
    }
}

/// Distance of every sample of the path on its curve from the nearest point of the target (n) [m].
pub fn errors(target: &TargetPath, tracked: &TrackedTip) -> Vec<f64> {
    distances(tracked.curve(), &target_line(target))
}

/// Points at equal distances along one lap of the target [m].
fn target_line(target: &TargetPath) -> Vec<PlanarPoint> {
    target.outline.evenly(target.outline.length() / TARGET_POINTS).into_iter().map(plane).collect()
}

fn plane([x, y, _]: [f64; 3]) -> PlanarPoint {
    [x, y]
}

fn mean_iou(target: &TargetPath, goal: &[PlanarPoint], tracked: &TrackedTip) -> Option<f64> {
    if !target.outline.is_closed() {
        return None;
    }
    let of_lap = |lap: &RangeInclusive<usize>| iou(goal, &tracked.points[lap.clone()]);
    let sum = tracked.laps.iter().map(of_lap).sum::<Option<f64>>()?;
    Some(sum / tracked.laps.len() as f64)
}

/// Aligned RMSE and lag.
fn over_time(
    target: &TargetPath,
    samples: &[PlanarPoint],
    tracked: &TrackedTip,
) -> (Option<f64>, Option<f64>) {
    let time: Vec<f64> = target.curve().map(|i| target.time(i)).collect();
    let goal = Timed { time: &time, points: samples };
    let path = Timed { time: &tracked.time, points: &tracked.points };
    (aligned_rmse(goal, path, 0.0), lag(goal, path, 1.0 / target.rate_hz))
}
