//! How much later than the strokes the tip is.
//!
//! The tip's change over a short time is regressed on the strokes' change some rows earlier; the delay is where the regression explains most
//! of it. Changes rather than positions: hysteresis moves the tip's place, but where a tendon moves the tip moves at once.
//!
//! Backlash and slack break that rule after each turn, and at constant speed they delay the tip for as long after every one. The two differ
//! in what the tip does meanwhile: with a delay it goes on as before the turn, with backlash it rests. A delay is reported where the first
//! explains the motion after turns better than the second.

use super::series::{MeasuredChannel, MeasuredSeries};
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
/// Largest plausible delay of servos and tracker [s]: 20 to 60 ms and 10 to 40 ms.
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
    /// Squared error after turns, over the tip's squared change there [-]: below 1, the tip goes on rather than rests.
    pub error_after_turns: f64,
}

pub fn check(series: &MeasuredSeries) -> Option<Warning> {
    let Delay { seconds, explained: [best, none], error_after_turns } = estimate(series)?;
    let is_backlash = seconds > 0.0 && error_after_turns >= 1.0;
    let is_reliable = best >= EXPLAINED && 1.0 - best < (1.0 - GAIN) * (1.0 - none) && !is_backlash;
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
    let inputs = |lag: isize| -> Vec<Vec<f64>> {
        let changes = |stroke: &MeasuredChannel| {
            rows.iter().map(|i| change(&stroke.values, i.saturating_add_signed(-lag))).collect()
        };
        series.strokes.iter().map(changes).collect()
    };
    let explained = |lag: isize| DelayRegression::of(&inputs(lag), &tips).explained / total;
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
    let error_after_turns = error_after_turns(&inputs(lag), &inputs(0), &tips);
    Some(Delay { seconds, explained: [best, none], error_after_turns })
}

/// Squared error of the tip predicted from late strokes, over that of a tip that rests, in the rows where late and present strokes predict
/// motions that differ by as much as motions at right angles; infinite where the tip rests, 0 without such rows.
fn error_after_turns(late: &[Vec<f64>], present: &[Vec<f64>], tips: &[Vec<f64>]) -> f64 {
    let fitted = DelayRegression::of(late, tips);
    let (mut error, mut rest) = (0.0, 0.0);
    for i in 0..tips[0].len() {
        let (mut squares, mut apart, mut missed, mut moved) = (0.0, 0.0, 0.0, 0.0);
        for (c, tip) in tips.iter().enumerate() {
            let [before, now] = [late, present].map(|strokes| fitted.predict(c, strokes, i));
            squares += before * before + now * now;
            apart += (before - now).powi(2);
            missed += (tip[i] - before).powi(2);
            moved += tip[i] * tip[i];
        }
        if apart >= squares {
            error += missed;
            rest += moved;
        }
    }
    if error > 0.0 { error / rest } else { 0.0 }
}

/// Linear combinations of strokes' changes that explain those of the tip, one for each of its axes.
struct DelayRegression {
    /// Weight of each stroke, for each axis (axes, m).
    weights: Vec<Vec<f64>>,
    /// Sum of the squares that they explain.
    explained: f64,
}

impl DelayRegression {
    /// By Cholesky's factor of the normal equations; a stroke that others explain counts once.
    fn of(inputs: &[Vec<f64>], outputs: &[Vec<f64>]) -> Self {
        let m = inputs.len();
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let mut factor = vec![0.0; m * m];
        for i in 0..m {
            for j in 0..=i {
                let sum: f64 = (0..j).map(|k| factor[i * m + k] * factor[j * m + k]).sum();
                let gram = dot(&inputs[i], &inputs[j]);
                let pivot = factor[j * m + j];
                factor[i * m + j] = match i == j {
                    true if gram - sum > 1e-9 * gram => (gram - sum).sqrt(),
                    false if pivot > 0.0 => (gram - sum) / pivot,
                    _ => 0.0,
                };
            }
        }
        let (mut weights, mut explained) = (Vec::new(), 0.0);
        for output in outputs {
            let mut right: Vec<f64> = inputs.iter().map(|input| dot(input, output)).collect();
            for i in 0..m {
                let sum: f64 = (0..i).map(|k| factor[i * m + k] * right[k]).sum();
                let pivot = factor[i * m + i];
                right[i] = if pivot > 0.0 { (right[i] - sum) / pivot } else { 0.0 };
                explained += right[i] * right[i];
            }
            for i in (0..m).rev() {
                let sum: f64 = (i + 1..m).map(|k| factor[k * m + i] * right[k]).sum();
                let pivot = factor[i * m + i];
                right[i] = if pivot > 0.0 { (right[i] - sum) / pivot } else { 0.0 };
            }
            weights.push(right);
        }
        Self { weights, explained }
    }

    /// Change of axis `c` in row `i`.
    fn predict(&self, c: usize, inputs: &[Vec<f64>], i: usize) -> f64 {
        self.weights[c].iter().zip(inputs).map(|(weight, input)| weight * input[i]).sum()
    }
}
