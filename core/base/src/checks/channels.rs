//! Checks of a single channel: it is frozen, is held, repeats rows, jumps, turns over, is cut off or is
//! coarse.

use std::f64::consts::TAU;

use super::series::{MeasuredChannel, MeasuredSeries};
use super::{Finding, LONGEST_STILL_S, MIN_ROWS, Warning};
use crate::statistics::{extremes, nearest_quantile, range, robust_deviation};
use crate::units::Unit;

/// Part of its range that a command moves over while nothing answers [-]: wider than backlash and friction of a tendon hold on.
const COMMAND_MOVES: f64 = 0.1;
/// A tip that goes on after a rest does so by steps like those that follow, of which so many are looked at; a tracker that was stopped
/// shows at once how far the tip has gone: by more than so many times the largest of them.
const JUMP: f64 = 3.0;
const AFTER_REST: usize = 10;
/// From this part of the rows on that repeat the one before, rows are held, not repeated by accident [-].
const HELD: f64 = 0.3;
/// Largest part of changes by a single quantum in values that are held rather than rounded [-].
const SINGLE_QUANTA: f64 = 0.5;
/// Fewest rows repeated singly that are reported: one may be two measurements that agree.
const MIN_DUPLICATES: usize = 3;
/// A spike in standard deviations of the channel about its running median [-]: in a million normal values none is beyond 5; measured
/// tails are longer.
const SPIKE_DEVIATIONS: f64 = 12.0;
/// And in parts of the channel's own range from the 1st to the 99th percentile [-].
const SPIKE_PART: f64 = 0.1;
/// And in what the channel moves at its speed of nearby [-]: motion that turns between two rows leaves them by at most once that.
const SPIKE_SPEED: f64 = 3.0;
/// Steps to either side from which that speed is taken, the second largest of them: another spike may be on one side.
const NEARBY: usize = 2;
/// Part of the root mean square change from row to row above which a channel certainly moves [-]; less may be the slow end of a
/// motion, by single steps of an encoder.
const FAST_PART: f64 = 0.5;
/// A jump within this part of a turn is a wrap [-]: what a joint moves between two rows is less.
const WRAP_PART: f64 = 0.1;
/// Fewest values of its own in which a channel has a shape that can be cut off.
const MIN_LEVELS: usize = 50;
/// Rows at the same extreme value, one after the other, from which it is cut off.
const MIN_PLATEAU: usize = 10;
/// Fewest such plateaus: a single one is a rest.
const MIN_PLATEAUS: usize = 2;
/// Levels across the range below which steps are coarse [-]: a step rounds by 1/√12 = 0.29 of itself, which is 0.3 % of the range
/// at a hundred levels. A good fit's error is 1 %.
const MIN_STEPS_OF_RANGE: f64 = 100.0;
/// How far a change may be from a whole number of quanta [quanta].
const QUANTUM_ROUNDING: f64 = 0.02;
/// A channel of a smaller range is at rest [m or rad]: a tracker's noise, and some steps of a servo's encoder of 4096.
const REST_RANGE: f64 = 3e-3;
/// Part of the rows in which a limit may have held a stroke back [-].
const LIMITED: f64 = 0.05;

pub fn check(series: &MeasuredSeries) -> Vec<Warning> {
    let mut found = Vec::new();
    let channels: Vec<&MeasuredChannel> = series.measured().collect();
    found.extend(still_tip(series));
    found.extend(held(&channels, series));
    found.extend(duplicated(series));
    for channel in channels {
        // At rest only the last digit of the sensor changes.
        let positions = channel.is_position() && range(channel.values.iter().copied()) > REST_RANGE;
        if channel.values.iter().all(|value| *value == channel.values[0]) {
            continue;
        }
        found.extend(wrap(channel, series).or_else(|| if positions { spike(channel, series) } else { None }));
        if positions {
            found.extend(saturated(channel, series));
        }
        if positions {
            found.extend(coarse(channel));
        }
    }
    found.extend(limited(series));
    found
}

/// The longest stretch in which the tip does not change by a bit while the strokes go on, and after which it is somewhere else: a tip that
/// goes on where it stood has rested, while slack was taken up or friction held.
fn still_tip(series: &MeasuredSeries) -> Option<Warning> {
    if series.strokes.is_empty() || series.tip.is_empty() {
        return None;
    }
    let is_same = |i: usize| series.tip.iter().all(|axis| axis.values[i] == axis.values[i - 1]);
    let n = series.time.len();
    let widths: Vec<f64> = series.strokes.iter().map(|stroke| range(stroke.values.iter().copied())).collect();
    let widest = widths.iter().copied().fold(0.0, f64::max);
    let (mut best, mut first) = (None, 0);
    for i in 1..=n {
        if i < n && is_same(i) {
            continue;
        }
        let lasts = series.time[i - 1] - series.time[first];
        let is_longer = best.is_none_or(|(_, _, longest, _)| lasts > longest);
        if i - first >= MIN_ROWS && lasts >= LONGEST_STILL_S && is_longer && i - first < n {
            let moved = |stroke: &MeasuredChannel| range(stroke.values[first..i].iter().copied());
            let moved = series.strokes.iter().map(moved).fold(0.0, f64::max);
            if moved > COMMAND_MOVES * widest && jumps(series, i) {
                best = Some((first, i - 1, lasts, moved));
            }
        }
        first = i;
    }
    let (first, last, lasts, moved) = best?;
    let finding = format!(
        "the tip does not change for {lasts:.2} s while a stroke moves by {:.2} mm (at most {LONGEST_STILL_S} s)",
        1e3 * moved
    );
    Some(
        Warning::new(Finding::Frozen, "tip", finding)
            .measured(lasts, LONGEST_STILL_S, "s")
            .at_rows(series.rows[first], series.rows[last])
            .hint("the tracker repeated its last pose: mark these rows as gaps"),
    )
}

/// True where the tip comes to row `i` by a larger step than the next one, or no next step exists.
fn jumps(series: &MeasuredSeries, i: usize) -> bool {
    let step = |i: usize| -> f64 {
        series.tip.iter().map(|axis| (axis.values[i] - axis.values[i - 1]).powi(2)).sum::<f64>().sqrt()
    };
    let after = i + 1..(i + 1 + AFTER_REST).min(series.time.len());
    after.is_empty() || step(i) > JUMP * after.map(step).fold(0.0, f64::max)
}

/// Channels of which most rows repeat the one before although what they change by is no single step of rounding.
fn held(channels: &[&MeasuredChannel], series: &MeasuredSeries) -> Vec<Warning> {
    let mut found: Vec<(Vec<&str>, f64)> = Vec::new();
    for channel in channels {
        let changes: Vec<f64> =
            channel.values.windows(2).map(|pair| (pair[1] - pair[0]).abs()).filter(|x| *x > 0.0).collect();
        let n = channel.values.len();
        if changes.len() < MIN_ROWS || changes.len() as f64 > (1.0 - HELD) * n as f64 {
            continue;
        }
        let quantum = quantum(&channel.values);
        let single = changes.iter().filter(|change| **change < 1.5 * quantum).count();
        if single as f64 > SINGLE_QUANTA * changes.len() as f64 {
            continue;
        }
        // Of the time in which it moves: a rest of the robot is no hold.
        let mut lengths = Vec::new();
        let mut length = 1.0;
        for pair in channel.values.windows(2) {
            if pair[0] == pair[1] {
                length += 1.0;
            } else {
                lengths.push(length);
                length = 1.0;
            }
        }
        let typical = nearest_quantile(&mut lengths, 0.5).unwrap_or(0.0);
        if typical < 2.0 {
            continue;
        }
        match found.iter_mut().find(|(_, of)| *of == typical) {
            Some((names, _)) => names.push(&channel.name),
            None => found.push((vec![&channel.name], typical)),
        }
    }
    let mut steps: Vec<f64> = series.time.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let step = nearest_quantile(&mut steps, 0.5).unwrap_or(0.0);
    let warning = |(names, rows): (Vec<&str>, f64)| {
        let finding = format!(
            "measured every {rows:.0} rows, at {:.1} Hz of {:.1}; in between the last value is repeated",
            1.0 / (rows * step),
            1.0 / step
        );
        Warning::new(Finding::SampleAndHold, names.join(", "), finding)
            .measured(rows, 1.0, "rows")
            .hint("resample it at the rate at which it was measured; speeds from differences are wrong")
    };
    found.into_iter().map(warning).collect()
}

/// Rows that repeat all that was measured in the row before, each alone.
fn duplicated(series: &MeasuredSeries) -> Option<Warning> {
    let n = series.time.len();
    let is_same = |i: usize| series.measured().all(|channel| channel.values[i] == channel.values[i - 1]);
    series.measured().next()?;
    let same: Vec<bool> = (0..n).map(|i| i > 0 && is_same(i)).collect();
    let is_single = |i: &usize| same[*i] && !same[*i - 1] && !same.get(*i + 1).copied().unwrap_or(false);
    // A channel at rest, or between two values of its rounding, repeats values; a moving one does not.
    let positions = series.measured().filter(|channel| channel.is_position());
    let positions: Vec<(&[f64], f64)> =
        positions.map(|channel| (&channel.values[..], fast_change(&channel.values))).collect();
    let is_moving = |i: &usize| {
        let moves = |k: usize| {
            let is_fast = |(values, fast): &(&[f64], f64)| (values[k] - values[k - 1]).abs() > *fast;
            k > 0 && k < n && positions.iter().any(is_fast)
        };
        moves(*i - 1) && moves(*i + 1)
    };
    let single: Vec<usize> = (1..n).filter(is_single).filter(is_moving).collect();
    let part = same.iter().filter(|same| **same).count() as f64 / n as f64;
    if single.len() < MIN_DUPLICATES || part > HELD {
        return None;
    }
    let finding = format!(
        "{} rows repeat all that was measured in the row before, {:.1} % (one or two may agree by chance)",
        single.len(),
        100.0 * single.len() as f64 / n as f64
    );
    Some(
        Warning::new(Finding::DuplicatedRow, "all measured", finding)
            .measured(single.len() as f64, (MIN_DUPLICATES - 1) as f64, "rows")
            .at_rows(series.rows[single[0]], series.rows[single[single.len() - 1]])
            .hint("the recorder was faster than its source: leave the repeated rows out"),
    )
}

/// A value or two that leave their neighbours and are back.
fn spike(channel: &MeasuredChannel, series: &MeasuredSeries) -> Option<Warning> {
    if !series.resolves_motion() {
        return None;
    }
    let values = &channel.values;
    let n = values.len();
    let departure = |i: usize| {
        let mut five: Vec<f64> = (i.saturating_sub(2)..(i + 3).min(n)).map(|k| values[k]).collect();
        values[i] - nearest_quantile(&mut five, 0.5).unwrap_or(0.0)
    };
    let departures: Vec<f64> = (0..n).map(departure).collect();
    let mut sorted = values.clone();
    let width = nearest_quantile(&mut sorted, 0.99).unwrap_or(0.0)
        - nearest_quantile(&mut sorted, 0.01).unwrap_or(0.0);
    let limit = (SPIKE_DEVIATIONS * robust_deviation(departures.iter().copied())).max(SPIKE_PART * width);
    // The first and the last two rows have neighbours on one side alone.
    let is_back = |i: usize| {
        let side = |k: usize| (values[i] - values[k]).abs() > 0.5 * limit;
        i >= 2 && i + 2 < n && side(i - 2) && side(i + 2)
    };
    let limit_at = |i: usize| limit.max(SPIKE_SPEED * moved_nearby(channel, &series.time, i));
    let is_spike =
        |i: &usize| departures[*i].abs() > limit && is_back(*i) && departures[*i].abs() > limit_at(*i);
    let spikes: Vec<usize> = (0..n).filter(is_spike).collect();
    let at = spikes.iter().copied().max_by(|a, b| departures[*a].abs().total_cmp(&departures[*b].abs()))?;
    let (unit, factor) = shown(channel);
    let (size, limit) = (factor * departures[at].abs(), factor * limit_at(at));
    let finding = format!(
        "{} rows leave their neighbours and are back within two rows; the largest by {size:.4} {unit} (at most {limit:.4})",
        spikes.len(),
    );
    Some(
        Warning::new(Finding::Spike, &channel.name, finding)
            .measured(size, limit, unit)
            .at_rows(series.rows[at], series.rows[at])
            .hint("no body moves so: mark these rows as gaps"),
    )
}

/// How far a channel moves from row `i` to the further of its neighbours, at the speed that it has around [unit of the channel].
fn moved_nearby(channel: &MeasuredChannel, time: &[f64], i: usize) -> f64 {
    let (values, last) = (&channel.values, time.len() - 1);
    let speed = |k: usize| ((values[k + 1] - values[k]) / (time[k + 1] - time[k])).abs();
    // Steps that the two rows of a spike have no part in.
    let before = i.saturating_sub(2 + NEARBY)..i.saturating_sub(2);
    let after = (i + 2).min(last)..(i + 2 + NEARBY).min(last);
    let mut speeds: Vec<f64> = before.chain(after).map(speed).collect();
    speeds.sort_by(|a, b| b.total_cmp(a));
    let speed = speeds.get(1).copied().unwrap_or(0.0);
    let step = |k: usize| if k < last { time[k + 1] - time[k] } else { 0.0 };
    speed * step(i.saturating_sub(1)).max(step(i))
}

/// A change from row to row of a channel that certainly moves.
fn fast_change(values: &[f64]) -> f64 {
    let squares = values.windows(2).map(|pair| (pair[1] - pair[0]).powi(2)).sum::<f64>();
    FAST_PART * (squares / values.len() as f64).sqrt()
}

/// The smallest change of a channel: a step of its rounding, or less.
fn quantum(values: &[f64]) -> f64 {
    let changes = values.windows(2).map(|pair| (pair[1] - pair[0]).abs());
    changes.filter(|change| *change > 0.0).fold(f64::INFINITY, f64::min)
}

/// Unit and factor in which values of a channel are shown.
fn shown(channel: &MeasuredChannel) -> (&'static str, f64) {
    match Unit::of_name(&channel.name).map(|(_, unit)| unit.si_suffix) {
        Some("m") => ("mm", 1e3),
        Some("rad") => ("rad", 1.0),
        _ => ("-", 1.0),
    }
}

/// Jumps of a whole turn.
fn wrap(channel: &MeasuredChannel, series: &MeasuredSeries) -> Option<Warning> {
    let turns: &[(f64, &str)] = if channel.name.ends_with("_rad") {
        &[(TAU, "2π rad"), (360.0, "360"), (std::f64::consts::PI, "π rad")]
    } else if channel.name.starts_with("tick_") {
        &[(4096.0, "4096 ticks"), (65536.0, "65536 ticks")]
    } else {
        return None;
    };
    let values = &channel.values;
    let jump = |i: usize| values[i] - values[i - 1];
    for &(turn, text) in turns {
        let is_jump = |i: usize| (jump(i).abs() - turn).abs() < WRAP_PART * turn;
        // Around a wrap the angle goes on slowly; a step of this size every row is a motion.
        let is_calm = |i: usize| {
            let near = [i.checked_sub(1).filter(|i| *i > 0), Some(i + 1).filter(|i| *i < values.len())];
            near.into_iter().flatten().all(|k| jump(k).abs() < WRAP_PART * turn)
        };
        let wraps: Vec<usize> = (1..values.len()).filter(|&i| is_jump(i) && is_calm(i)).collect();
        if let Some(first) = wraps.first() {
            let finding = format!(
                "{} jumps of a turn ({text}) between two rows, the first by {:.4}",
                wraps.len(),
                jump(*first)
            );
            return Some(
                Warning::new(Finding::Wrap, &channel.name, finding)
                    .measured(
                        jump(*first).abs(),
                        (1.0 - WRAP_PART) * turn,
                        if turn == TAU { "rad" } else { "-" },
                    )
                    .at_rows(series.rows[first - 1], series.rows[*first])
                    .hint("unwrap it: add a turn to all that follows"),
            );
        }
    }
    None
}

/// Plateaus at the largest or smallest value that a channel runs into with speed.
fn saturated(channel: &MeasuredChannel, series: &MeasuredSeries) -> Option<Warning> {
    let values = &channel.values;
    let changes = values.windows(2).filter(|pair| pair[1] != pair[0]).count();
    // As many changes as levels at least; a channel in coarse steps has plateaus by rounding.
    if changes < MIN_LEVELS || changes as f64 <= (1.0 - HELD) * values.len() as f64 * 0.5 {
        return None;
    }
    let fast = fast_change(values);
    for extreme in extremes(values.iter().copied()) {
        let (mut plateaus, mut rows, mut first, mut i) = (0, 0, None, 0);
        while i < values.len() {
            if values[i] != extreme {
                i += 1;
                continue;
            }
            let length = values[i..].iter().take_while(|value| **value == extreme).count();
            // Motion that turns or comes to rest slows down before; what is cut off does not.
            let is_fast = i > 1 && (values[i - 1] - values[i - 2]).abs() > fast;
            if length >= MIN_PLATEAU && is_fast {
                plateaus += 1;
                rows += length;
                first.get_or_insert((i, i + length - 1));
            }
            i += length;
        }
        if let Some((from, to)) = first.filter(|_| plateaus >= MIN_PLATEAUS) {
            let (unit, factor) = shown(channel);
            let part = 100.0 * rows as f64 / values.len() as f64;
            let finding = format!(
                "stops dead at {:.4} {unit} {plateaus} times, {rows} rows, {part:.1} % of all",
                factor * extreme
            );
            return Some(
                Warning::new(Finding::Saturation, &channel.name, finding)
                    .measured(part, 0.0, "%")
                    .at_rows(series.rows[from], series.rows[to])
                    .hint("the sensor, or a stop, cut it off: a smaller motion, or leave these rows out"),
            );
        }
    }
    None
}

/// Steps between values that are a large part of the range.
fn coarse(channel: &MeasuredChannel) -> Option<Warning> {
    let changes: Vec<f64> =
        channel.values.windows(2).map(|pair| (pair[1] - pair[0]).abs()).filter(|x| *x > 0.0).collect();
    if changes.len() < MIN_ROWS {
        return None;
    }
    let quantum = quantum(&channel.values);
    let levels = range(channel.values.iter().copied()) / quantum;
    if levels >= MIN_STEPS_OF_RANGE {
        return None;
    }
    let is_whole = |change: &&f64| {
        let quanta = **change / quantum;
        (quanta - quanta.round()).abs() < QUANTUM_ROUNDING
    };
    if changes.iter().filter(is_whole).count() as f64 <= 0.95 * changes.len() as f64 {
        return None;
    }
    let finding = format!(
        "{levels:.0} steps across its range (at least {MIN_STEPS_OF_RANGE:.0}): rounding alone scatters by {:.1} % of the range",
        100.0 / (levels * 12f64.sqrt())
    );
    Some(
        Warning::new(Finding::Quantisation, &channel.name, finding)
            .measured(levels, MIN_STEPS_OF_RANGE, "steps")
            .hint("record more digits, or a larger motion"),
    )
}

/// Strokes clipped by a limit.
fn limited(series: &MeasuredSeries) -> Option<Warning> {
    let flags = series.recording.channel("limited")?;
    let part = flags.iter().filter(|flag| **flag > 0.0).count() as f64 / flags.len() as f64;
    if part <= LIMITED {
        return None;
    }
    let finding = format!(
        "a limit held strokes back in {:.1} % of the rows (at most {:.0} %)",
        100.0 * part,
        100.0 * LIMITED
    );
    Some(
        Warning::new(Finding::Saturation, "limited", finding)
            .measured(100.0 * part, 100.0 * LIMITED, "%")
            .hint("the path asks for more than the tendons may do: smaller or slower"),
    )
}
