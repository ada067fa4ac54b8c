//! How much later than the strokes the tip is.
//!
//! The tip's change over a short time is regressed on the strokes' change some rows earlier; the delay is where the regression explains most
//! of it. Changes rather than positions: hysteresis moves the tip's place, but where a tendon moves the tip moves at once.

use super::series::MeasuredSeries;
use super::{Finding, Warning};

/// Delays that are tried, before and after [s].
const TRIED_S: [f64; 2] = [-0.25, 1.5];
/// Changes are over this time [s]: short against a robot's motion, long enough for a tracker's noise.
const CHANGE_S: f64 = 0.1;
/// Most rows and most delays that are compared: a tenth of a second of work.
const MAX_ROWS: usize = 3000;
const MAX_DELAYS: usize = 120;
/// Most tendons.
const MAX_STROKES: usize = 16;
/// Fewest rows for an unknown.
const ROWS_PER_STROKE: usize = 20;
/// Largest delay that is believed to be servos and tracker [s]: 20 to 60 ms and 10 to 40 ms.
const LARGEST_S: f64 = 0.1;
/// Part of the change that must be explained [-], and by how much more than at no delay: a hundredth of the error itself twice over, as in
/// the fit of the inverse controller's delay.
const EXPLAINED: f64 = 0.5;
const GAIN: f64 = 0.02;

/// A delay with how much it explains.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Delay {
    /// By how much the tip is later than the strokes [s].
    pub seconds: f64,
    /// Part of the tip's change that the strokes explain, with this delay and without [-].
    pub explained: [f64; 2],
}

pub fn check(series: &MeasuredSeries) -> Option<Warning> {
    let Delay { seconds, explained: [best, none] } = estimate(series)?;
    let is_reliable = best >= EXPLAINED && 1.0 - best < (1.0 - GAIN) * (1.0 - none);
    let step = series.recording.rate_hz()?.recip();
    let limit = if seconds < 0.0 { step } else { LARGEST_S.max(step) };
    if !is_reliable || seconds.abs() <= limit {
        return None;
    }
    let (which, hint) = match seconds < 0.0 {
        true => ("before", "no tip moves before its tendons: are the stamps those of one clock?"),
        false => (
            "after",
            "without it, a fit takes the delay for hysteresis: shift the tip, or stamp both with one clock",
        ),
    };
    let finding = format!(
        "the tip moves {:.0} ms {which} the strokes (at most {:.0}); so they explain {:.0} % of its motion, without delay {:.0} %",
        1e3 * seconds.abs(),
        1e3 * limit,
        100.0 * best,
        100.0 * none
    );
    Some(Warning::new(Finding::Delay, "tip, strokes", finding).measured(seconds, limit, "s").hint(hint))
}

/// The delay of the tip behind the strokes; `None` without a rate, strokes, a tip, or with too few rows.
pub fn estimate(series: &MeasuredSeries) -> Option<Delay> {
    let rate = series.recording.rate_hz()?;
    let m = series.strokes.len();
    let is_whole = series.rows.len() == series.recording.n_samples();
    if m == 0 || m > MAX_STROKES || series.tip.is_empty() || !is_whole {
        return None;
    }
    let n = series.time.len();
    let width = ((CHANGE_S * rate).round() as usize).max(1);
    let [before, after] = TRIED_S.map(|seconds| (seconds.abs() * rate).floor() as usize);
    let (after, before) = (after.min(n / 4), before.min(n / 8));
    let lag_step = (before + after).div_ceil(MAX_DELAYS).max(1);
    let first = after;
    let last = n.checked_sub(width + before)?;
    if last <= first + ROWS_PER_STROKE * m {
        return None;
    }
    let stride = (last - first).div_ceil(MAX_ROWS).max(1);
    let rows: Vec<usize> = (first..last).step_by(stride).collect();
    let change = |values: &[f64], i: usize| values[i + width] - values[i];
    let tips: Vec<Vec<f64>> =
        series.tip.iter().map(|axis| rows.iter().map(|i| change(&axis.values, *i)).collect()).collect();
    let total: f64 = tips.iter().flatten().map(|x| x * x).sum();
    if total == 0.0 {
        return None;
    }
    let explained = |lag: isize| -> f64 {
        let inputs: Vec<Vec<f64>> = series
            .strokes
            .iter()
            .map(|s| rows.iter().map(|i| change(&s.values, i.saturating_add_signed(-lag))).collect())
            .collect();
        tips.iter().map(|tip| explained_square(&inputs, tip)).sum::<f64>() / total
    };
    let behind = (after / lag_step) as isize;
    let ahead = (before / lag_step) as isize;
    let tried: Vec<(isize, f64)> =
        (-ahead..=behind).map(|k| k * lag_step as isize).map(|lag| (lag, explained(lag))).collect();
    let none = tried[usize::try_from(ahead).ok()?].1;
    let at = (0..tried.len()).max_by(|a, b| tried[*a].1.total_cmp(&tried[*b].1))?;
    let (lag, best) = tried[at];
    let sides = at.checked_sub(1).and_then(|i| Some((tried[i].1, tried.get(at + 1)?.1)));
    let part = sides.map_or(0.0, |(left, right)| {
        let bend = left - 2.0 * best + right;
        if bend < 0.0 { (0.5 * (left - right) / bend).clamp(-0.5, 0.5) } else { 0.0 }
    });
    let seconds = (lag as f64 + part * lag_step as f64) / rate;
    Some(Delay { seconds, explained: [best, none] })
}

/// Sum of the squares of `output` that a linear combination of `inputs` explains; 0 where these are zero.
fn explained_square(inputs: &[Vec<f64>], output: &[f64]) -> f64 {
    let m = inputs.len();
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let mut gram = vec![0.0; m * m];
    for i in 0..m {
        for j in 0..=i {
            gram[i * m + j] = dot(&inputs[i], &inputs[j]);
        }
    }
    let mut right: Vec<f64> = inputs.iter().map(|input| dot(input, output)).collect();
    // Cholesky's factor; a stroke that others explain counts once.
    let mut explained = 0.0;
    for i in 0..m {
        let original = gram[i * m + i];
        for j in 0..i {
            let sum: f64 = (0..j).map(|k| gram[i * m + k] * gram[j * m + k]).sum();
            let pivot = gram[j * m + j];
            gram[i * m + j] = if pivot > 0.0 { (gram[i * m + j] - sum) / pivot } else { 0.0 };
        }
        let left = original - (0..i).map(|k| gram[i * m + k].powi(2)).sum::<f64>();
        gram[i * m + i] = if left > 1e-9 * original { left.sqrt() } else { 0.0 };
        let sum: f64 = (0..i).map(|k| gram[i * m + k] * right[k]).sum();
        right[i] = if gram[i * m + i] > 0.0 { (right[i] - sum) / gram[i * m + i] } else { 0.0 };
        explained += right[i] * right[i];
    }
    explained
}
