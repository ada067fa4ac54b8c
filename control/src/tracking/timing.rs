//! Errors at the same time, and how late a path comes.

use super::curve::{PlanarPoint, distance};

/// Largest lag that is looked for, either way [s].
const LARGEST_LAG: f64 = 2.0;
/// Part of the target's samples that a shifted path must still have.
const MIN_PART: f64 = 0.5;

/// Measured points over time.
#[derive(Debug, Clone, Copy)]
pub struct Timed<'a> {
    /// Times (n) in increasing order [s].
    pub time: &'a [f64],
    /// Where the tip was (n) [m].
    pub points: &'a [PlanarPoint],
}

impl Timed<'_> {
    /// Where the tip was at time `t` [s], between samples on the line between them; `None` outside.
    pub fn at(&self, t: f64) -> Option<PlanarPoint> {
        let next = self.time.partition_point(|time| *time < t);
        if next == self.time.len() {
            return None;
        }
        if self.time[next] == t {
            return Some(self.points[next]);
        }
        let before = next.checked_sub(1)?;
        let part = (t - self.time[before]) / (self.time[next] - self.time[before]);
        Some([0, 1].map(|c| self.points[before][c] + part * (self.points[next][c] - self.points[before][c])))
    }
}

/// Root mean square distance from the target at the same times [m], the path taken `shift` [s] later; `None` where
/// it has fewer than half of the times.
pub fn aligned_rmse(target: Timed, path: Timed, shift: f64) -> Option<f64> {
    let pairs = target.time.iter().zip(target.points);
    let squares = pairs.filter_map(|(t, goal)| Some(distance(path.at(t + shift)?, *goal).powi(2)));
    let (sum, n) = squares.fold((0.0, 0usize), |(sum, n), square| (sum + square, n + 1));
    (n > 0 && n as f64 >= MIN_PART * target.time.len() as f64).then(|| (sum / n as f64).sqrt())
}

/// By how much the path comes later than the target [s]: the shift with the smallest [`aligned_rmse`], of those up to
/// 2 s either way; `step` [s] apart, then between these by the parabola through the three best. `None` where the path
/// has too few of the times.
pub fn lag(target: Timed, path: Timed, step: f64) -> Option<f64> {
    let n = (LARGEST_LAG / step).round() as i64;
    let squared = |k: i64| aligned_rmse(target, path, k as f64 * step).map(|rmse| rmse * rmse);
    let tried: Vec<(i64, f64)> = (-n..=n).filter_map(|k| Some((k, squared(k)?))).collect();
    let best = (0..tried.len()).min_by(|a, b| tried[*a].1.total_cmp(&tried[*b].1))?;
    let (k, here) = tried[best];
    // At the end of what was tried there is no parabola.
    let sides = best.checked_sub(1).and_then(|i| Some((tried[i].1, tried.get(best + 1)?.1)));
    let bend = sides.map_or(0.0, |(before, after)| before - 2.0 * here + after);
    let part = match sides {
        Some((before, after)) if bend > 0.0 => 0.5 * (before - after) / bend,
        _ => 0.0,
    };
    Some((k as f64 + part) * step)
}
