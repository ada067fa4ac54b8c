//! Numbers of an arm's joints that look as if they had another unit than the one stated.

use std::collections::HashMap;

use super::{Finding, Warning};
use crate::units::Unit;
use crate::{Channel, Recording};

/// Largest size that a quantity of a joint has on any arm, its unit, and the unit that a larger one hints at. Four turns; ten turns a
/// second; the largest industrial arm; a motor drive; a welding cell's supply.
const LARGEST: [(&str, f64, &str, &str); 7] = [
    ("q", 8.0 * std::f64::consts::PI, "rad or m", "deg"),
    ("goal", 8.0 * std::f64::consts::PI, "rad or m", "deg"),
    ("dq", 20.0 * std::f64::consts::PI, "rad/s or m/s", "deg_s"),
    ("tau", 2e4, "N m or N", "n_mm"),
    ("current", 200.0, "A", "ma"),
    ("voltage", 1000.0, "V", "mv"),
    ("pwm", 2.0, "-", "percent"),
];
/// Temperatures at which motors run [deg C].
const TEMPERATURES: [f64; 2] = [-60.0, 250.0];
/// Nothing is colder [deg C].
const ABSOLUTE_ZERO: f64 = -273.15;
/// Speeds that differ by this factor from the change of the coordinate have another unit: degrees make 57, turns per minute 9.5
/// [-].
const SPEED_FACTOR: f64 = 4.0;
/// Currents at full duty cycle, from what is recorded at any: some hundredths of a small servo's at stall; a large drive's [A].
const CURRENTS_AT_FULL_PWM: [f64; 2] = [0.01, 1000.0];
/// A mean duty cycle below this has no information: its motor is at rest, and its sensor of current reads noise [-].
const IDLE_PWM: f64 = 0.02;
/// A joint at this speed or more moves [rad/s or m/s].
const MOVING: f64 = 0.05;
/// A quarter of the finest resolution of servo currents: the median of moving motors' is larger [A].
const SMALLEST_CURRENT: f64 = 2.5e-4;
/// Below this correlation the change of the coordinate does not determine the speed [-].
const CORRELATION: f64 = 0.7;
/// How far coordinates may lie outside a joint's range, in ranges [-].
const OUTSIDE: f64 = 0.5;
/// More joints than any arm of which there are recordings.
const MAX_JOINTS: usize = 64;

/// A quantity of a joint: name and values.
type JointQuantity<'a> = Option<(&'a str, &'a [f64])>;
/// Channels by their names without the unit.
struct JointChannels<'a>(HashMap<&'a str, (&'a str, &'a [f64])>);

impl<'a> JointChannels<'a> {
    fn of(recording: &'a Recording) -> Self {
        let named = |channel: &'a Channel| {
            Some((Unit::of_name(&channel.name)?.0, (channel.name.as_str(), channel.values.as_slice())))
        };
        Self(recording.channels().iter().filter_map(named).collect())
    }

    /// A quantity of a joint, k from 0, in any unit.
    fn get(&self, stem: &str, k: usize) -> JointQuantity<'a> {
        self.0.get(format!("{stem}_{}", k + 1).as_str()).copied()
    }
}

/// One finding for each channel at most.
pub fn check(recording: &Recording, ranges: &[Option<[f64; 2]>]) -> Vec<Warning> {
    let mut found = Vec::new();
    let channels = JointChannels::of(recording);
    for k in 0..MAX_JOINTS {
        for (stem, most, unit, hint) in LARGEST {
            let Some((name, values)) = channels.get(stem, k) else { continue };
            let Some(row) = values.iter().position(|value| value.abs() > most) else { continue };
            let finding =
                format!("{:.4} in row {}; at most {most:.0} {unit} is plausible", values[row], row + 1);
            found.push(suspect(name, finding, hint).measured(values[row], most, unit).at_rows(row, row));
        }
        found.extend(temperature(channels.get("temperature", k)));
        let (position, speed) = (channels.get("q", k), channels.get("dq", k));
        found.extend(speeds(recording, position, speed));
        found.extend(range(position, ranges.get(k).copied().flatten()));
    }
    found.extend(currents(&channels));
    found
}

fn suspect(name: &str, finding: String, unit: &str) -> Warning {
    Warning::new(Finding::Unit, name, finding).hint(format!(
        "is the unit {unit}? write it in the name of the column; --accept-units accepts the numbers"
    ))
}

fn temperature(joint: JointQuantity) -> Option<Warning> {
    let (name, values) = joint?;
    let [least, most] = TEMPERATURES;
    let row = values.iter().position(|value| !(least..=most).contains(value))?;
    let value = values[row];
    let finding = format!("{value:.1} in row {}; {least:.0} to {most:.0} deg C is plausible", row + 1);
    let limit = if value < least { least } else { most };
    let warning = Warning::new(Finding::Unit, name, finding)
        .measured(value, limit, "deg C")
        .at_rows(row, row)
        .hint("temperatures are in degrees Celsius");
    Some(if value < ABSOLUTE_ZERO { warning.impossible() } else { warning })
}

/// The slope of the coordinate's change over the speed is one.
fn speeds(recording: &Recording, position: JointQuantity, speed: JointQuantity) -> Option<Warning> {
    let ((_, q), (name, dq)) = (position?, speed?);
    let (time, gap) = (recording.time(), recording.gap());
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for i in 1..time.len().saturating_sub(1) {
        if gap[i - 1..=i + 1].contains(&true) {
            continue;
        }
        let change = (q[i + 1] - q[i - 1]) / (time[i + 1] - time[i - 1]);
        xx += dq[i] * dq[i];
        xy += dq[i] * change;
        yy += change * change;
    }
    let (slope, correlation) = (xy / xx, xy / (xx * yy).sqrt());
    // A slope against a noisy speed is too small: both ways are asked.
    if correlation.is_nan()
        || correlation.abs() <= CORRELATION
        || (1.0 / SPEED_FACTOR..=SPEED_FACTOR).contains(&slope)
    {
        return None;
    }
    let finding = format!(
        "the coordinate changes {slope:.3} times as fast as the recorded speeds; {} to {SPEED_FACTOR} times is plausible",
        1.0 / SPEED_FACTOR
    );
    let limit = if slope > SPEED_FACTOR { SPEED_FACTOR } else { 1.0 / SPEED_FACTOR };
    let warning = suspect(name, finding, "another, or the sign of one of them").measured(slope, limit, "-");
    Some(Warning { kind: Finding::Speed, ..warning })
}

fn range(position: JointQuantity, range: Option<[f64; 2]>) -> Option<Warning> {
    let ((name, values), [min, max]) = (position?, range?);
    let margin = OUTSIDE * (max - min);
    let row = values.iter().position(|q| *q < min - margin || *q > max + margin)?;
    let finding = format!("{:.4} in row {}; the joint's range is {min:.3} to {max:.3}", values[row], row + 1);
    let limit = if values[row] < min { min - margin } else { max + margin };
    Some(suspect(name, finding, "deg").measured(values[row], limit, "rad or m").at_rows(row, row))
}

/// Currents are the part of the motors' currents at stall that duty cycles are, and moving motors need some. All joints together: one
/// of them may be at rest, be moved by hand, or have no sensor.
fn currents(channels: &JointChannels) -> Option<Warning> {
    let warning = |finding: String, value: f64, limit: f64, unit: &str| {
        Some(suspect("current_*_a", finding, unit).measured(value, limit, "A"))
    };
    let all = |stem: &'static str| (0..MAX_JOINTS).map(move |k| Some(channels.get(stem, k)?.1));
    let mean = |values: &[f64]| values.iter().map(|x| x.abs()).sum::<f64>() / values.len() as f64;
    let pairs =
        all("current").zip(all("pwm")).filter_map(|(current, pwm)| Some((mean(current?), mean(pwm?))));
    let (current, pwm) = pairs
        .filter(|(current, pwm)| *current > 0.0 && *pwm > IDLE_PWM)
        .fold((0.0, 0.0), |sums, pair| (sums.0 + pair.0, sums.1 + pair.1));
    if pwm > 0.0 {
        let ([least, most], at_full) = (CURRENTS_AT_FULL_PWM, current / pwm);
        if !(least..=most).contains(&at_full) {
            let (unit, limit) = if at_full < least { ("a", least) } else { ("ma", most) };
            let finding = format!("{at_full:.2e} A at full PWM; {least} to {most} A is plausible");
            return warning(finding, at_full, limit, unit);
        }
    }
    let moving = |(current, speed): (Option<&[f64]>, Option<&[f64]>)| -> Option<Vec<f64>> {
        let rows = current?.iter().zip(speed?);
        Some(rows.filter(|(i, dq)| **i != 0.0 && dq.abs() >= MOVING).map(|(i, _)| i.abs()).collect())
    };
    let mut moving: Vec<f64> = all("current").zip(all("dq")).filter_map(moving).flatten().collect();
    if moving.is_empty() {
        return None;
    }
    let median = crate::statistics::nearest_quantile(&mut moving, 0.5).unwrap_or(0.0);
    if median >= SMALLEST_CURRENT {
        return None;
    }
    let finding = format!(
        "{median:.2e} A in the median of motors that move; {SMALLEST_CURRENT} A or more is plausible"
    );
    warning(finding, median, SMALLEST_CURRENT, "a")
}
