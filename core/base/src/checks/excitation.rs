//! Whether recordings that are used together move the robot enough for a fit.

use super::series::{is_command, resolves_motion};
use super::{Finding, MIN_ROWS, Warning};
use crate::Recording;
use crate::statistics::{extremes, noise, range};

/// Range of a stroke below which a tendon counts as not pulled, as a part of the widest stroke [-].
const PULLED: f64 = 0.02;
/// Correlation of strokes from which tendons are pulled together [-]: what differs is below a hundredth of what they share.
const TOGETHER: f64 = 0.9999;
/// Fewest reversals of the strokes from which friction and backlash are distinguished from elasticity: two
/// make one loop, and a second loop shows how well it repeats.
const MIN_REVERSALS: usize = 4;
/// A stroke turns where it goes back by this part of its range [-]; wider than what a rig's noise does.
const TURNS: f64 = 0.1;
/// Smallest range of the tip in standard deviations of its noise [-]: at 20 the noise alone is an error of 5 % of the range.
const MIN_SIGNAL: f64 = 20.0;
/// A joint of a smaller range does not move [rad or m]: some degrees of a servo's backlash are less.
const JOINT_MOVES: f64 = 0.02;

pub fn check(recordings: &[(&str, &Recording)]) -> Vec<Warning> {
    let mut found = strokes(recordings);
    found.extend(noisy_tip(recordings));
    found.extend(joints(recordings));
    found
}

/// Strokes of all recordings with the same number of tendons, one after the other.
fn strokes(recordings: &[(&str, &Recording)]) -> Vec<Warning> {
    let columns: Vec<Vec<&[f64]>> = recordings.iter().map(|(_, recording)| recording.strokes()).collect();
    let n = columns.first().map_or(0, Vec::len);
    let rows: usize = recordings.iter().map(|(_, recording)| recording.n_samples()).sum();
    if n == 0 || rows < MIN_ROWS || columns.iter().any(|of| of.len() != n) {
        return Vec::new();
    }
    let of = |k: usize| columns.iter().flat_map(move |of| of[k].iter().copied());
    let widths: Vec<f64> = (0..n).map(|k| range(of(k))).collect();
    let widest = widths.iter().copied().fold(0.0, f64::max);
    let mut found = Vec::new();
    if widest == 0.0 {
        let warning = Warning::new(Finding::Excitation, "strokes", "no stroke ever changes");
        found.push(warning.measured(0.0, 0.0, "mm").hint("are these the recordings of a motion?"));
        return found;
    }
    let idle = (0..n).filter(|k| widths[*k] < PULLED * widest);
    let idle: Vec<String> = idle.map(|k| format!("stroke_{}_m", k + 1)).collect();
    if !idle.is_empty() {
        let finding = format!(
            "{} of {n} tendons move by less than {:.0} % of the widest stroke, {:.2} mm",
            idle.len(),
            100.0 * PULLED,
            1e3 * widest
        );
        let warning = Warning::new(Finding::Tendon, idle.join(", "), finding);
        let widest_idle = (0..n).map(|k| widths[k]).filter(|w| *w < PULLED * widest).fold(0.0, f64::max);
        let warning = warning.measured(1e3 * widest_idle, 1e3 * PULLED * widest, "mm");
        found.push(
            warning.hint("the effect of these tendons is not determined: record motions that pull them"),
        );
    }
    found.extend(together(n, &of, &widths, PULLED * widest));
    let reversals = columns.iter().map(|of| of.iter().enumerate().map(|(k, s)| turns(s, TURNS * widths[k])));
    let per_tendon: Vec<usize> =
        reversals.fold(vec![0; n], |sum, of| sum.iter().zip(of).map(|(a, b)| a + b).collect());
    let most = per_tendon.into_iter().max().unwrap_or(0);
    if most < MIN_REVERSALS {
        let finding = format!("the strokes turn {most} times (at least {MIN_REVERSALS}: two loops)");
        let warning = Warning::new(Finding::Excitation, "strokes", finding);
        found.push(
            warning.measured(most as f64, MIN_REVERSALS as f64, "reversals").hint(
                "friction and backlash show only where a tendon turns: pull and release more than once",
            ),
        );
    }
    found
}

/// All tendons that are pulled, always at once and in one proportion.
fn together<I: Iterator<Item = f64>>(
    n: usize,
    of: &impl Fn(usize) -> I,
    widths: &[f64],
    least: f64,
) -> Option<Warning> {
    let pulled: Vec<usize> = (0..n).filter(|k| widths[*k] >= least).collect();
    let (first, others) = pulled.split_first()?;
    if others.is_empty() {
        return None;
    }
    let lowest = others.iter().map(|k| correlation(of, *first, *k)).fold(1.0, f64::min);
    (lowest > TOGETHER).then(|| {
        let finding = format!("all tendons are always pulled together: correlations of {lowest:.5} and more (at most {TOGETHER})");
        Warning::new(Finding::Tendon, "strokes", finding)
            .measured(lowest, TOGETHER, "-")
            .hint("they only press the body together: record motions that bend it")
    })
}

fn correlation<I: Iterator<Item = f64>>(of: &impl Fn(usize) -> I, first: usize, second: usize) -> f64 {
    let pairs = || of(first).zip(of(second));
    let (sum, n) = pairs().fold(([0.0; 2], 0.0), |(sum, n), (a, b)| ([sum[0] + a, sum[1] + b], n + 1.0));
    let mean = sum.map(|sum| sum / n);
    let [aa, ab, bb] = pairs().fold([0.0; 3], |[aa, ab, bb], (a, b)| {
        let (a, b) = (a - mean[0], b - mean[1]);
        [aa + a * a, ab + a * b, bb + b * b]
    });
    ab / (aa * bb).sqrt()
}

/// How often a signal turns and goes back by `least`.
fn turns(values: &[f64], least: f64) -> usize {
    let (mut count, mut direction) = (0, 0.0);
    let mut extreme = values.first().copied().unwrap_or(0.0);
    for value in values {
        if direction * (value - extreme) >= 0.0 && direction != 0.0 {
            extreme = *value;
        } else if (value - extreme).abs() > least {
            if direction != 0.0 {
                count += 1;
            }
            direction = (value - extreme).signum();
            extreme = *value;
        }
    }
    count
}

fn noisy_tip(recordings: &[(&str, &Recording)]) -> Option<Warning> {
    let of = |recording: &Recording| -> Option<(f64, f64)> {
        let axes = ["tip_x_m", "tip_y_m", "tip_z_m"].into_iter().filter_map(|axis| recording.channel(axis));
        axes.map(|axis| (range(axis.iter().copied()), noise(axis))).max_by(|a, b| a.0.total_cmp(&b.0))
    };
    // Of rows slower than the motion, what differs between neighbours is motion.
    let is_assessed =
        |recording: &Recording| recording.n_samples() >= MIN_ROWS && resolves_motion(recording.time());
    let long = recordings.iter().filter(|(_, recording)| is_assessed(recording));
    let measured: Vec<(f64, f64)> = long.filter_map(|(_, recording)| of(recording)).collect();
    let (width, deviation) = measured.into_iter().max_by(|a, b| a.0.total_cmp(&b.0))?;
    let ratio = width / deviation;
    (ratio < MIN_SIGNAL).then(|| {
        let finding = format!(
            "the tip ranges over {:.3} mm with a noise of {:.3} mm: {ratio:.1} times (at least {MIN_SIGNAL:.0})",
            1e3 * width,
            1e3 * deviation
        );
        Warning::new(Finding::Excitation, "tip", finding)
            .measured(ratio, MIN_SIGNAL, "-")
            .hint("a larger motion, or a quieter tracker")
    })
}

/// Joints of an arm that never move.
fn joints(recordings: &[(&str, &Recording)]) -> Option<Warning> {
    if recordings.iter().map(|(_, recording)| recording.n_samples()).sum::<usize>() < MIN_ROWS {
        return None;
    }
    let names: Vec<&str> = recordings
        .first()?
        .1
        .channels()
        .iter()
        .map(|channel| channel.name.as_str())
        .filter(|name| name.starts_with("q_") && !is_command(name))
        .collect();
    let width = |name: &str| {
        let all = recordings.iter().filter_map(|(_, recording)| recording.channel(name));
        let [min, max] = extremes(all.flatten().copied());
        max - min
    };
    let still: Vec<&str> = names.iter().copied().filter(|name| width(name) < JOINT_MOVES).collect();
    let widest = still.iter().map(|name| width(name)).fold(0.0, f64::max);
    (!still.is_empty()).then(|| {
        let unit = if still[0].ends_with("_m") { "m" } else { "rad" };
        let finding = format!(
            "{} of {} joints move by less than {JOINT_MOVES} {unit}, at most {widest:.4}",
            still.len(),
            names.len()
        );
        Warning::new(Finding::Excitation, still.join(", "), finding)
            .measured(widest, JOINT_MOVES, unit)
            .hint("parameters of these joints are not determined")
    })
}
