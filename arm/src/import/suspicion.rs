//! Numbers that look as if they had another unit than the one stated.

use hysteron_base::BadInput;

use crate::{JointSeries, Model, Quantity, Recorded};

/// Largest size that a quantity of a joint has on any arm, and the unit that a larger one hints at. Four turns; ten turns a
/// second; the largest industrial arm; a motor drive; a welding cell's supply.
const LARGEST: [(Quantity, f64, &str); 7] = [
    (Quantity::Position, 8.0 * std::f64::consts::PI, "deg"),
    (Quantity::Goal, 8.0 * std::f64::consts::PI, "deg"),
    (Quantity::Velocity, 20.0 * std::f64::consts::PI, "deg_s"),
    (Quantity::Torque, 2e4, "n_mm"),
    (Quantity::Current, 200.0, "ma"),
    (Quantity::Voltage, 1000.0, "mv"),
    (Quantity::Pwm, 2.0, "percent"),
];
/// Temperatures at which motors run [deg C].
const TEMPERATURES: [f64; 2] = [-60.0, 250.0];
/// Speeds that differ by this factor from the change of the coordinate have another unit: degrees make 57, turns per minute 9.5
/// [-].
const SPEED_FACTOR: f64 = 4.0;
/// Currents at full duty cycle, from what is recorded at any: some hundredths of a small servo's at stall; a large drive's [A].
const CURRENTS_AT_FULL_PWM: [f64; 2] = [0.01, 1000.0];
/// A mean duty cycle below this says nothing: its motor stands, and its sensor of current reads noise [-].
const IDLE_PWM: f64 = 0.02;
/// A joint at this speed or more moves [rad/s or m/s].
const MOVING: f64 = 0.05;
/// A quarter of the finest step in which servos tell their currents: the median of moving motors' is larger [A].
const SMALLEST_CURRENT: f64 = 2.5e-4;
/// Below this correlation the change of the coordinate says nothing about the speed [-].
const CORRELATION: f64 = 0.7;
/// How far coordinates may lie outside a joint's range, in ranges [-].
const OUTSIDE: f64 = 0.5;

/// Refuses them.
pub(super) fn check(recorded: &Recorded, model: Option<&Model>) -> Result<(), BadInput> {
    for (k, joint) in recorded.joints.iter().enumerate() {
        for (quantity, most, hint) in LARGEST {
            let Some(values) = joint.of(quantity) else { continue };
            if let Some(row) = values.iter().position(|value| value.abs() > most) {
                return Err(suspicious(
                    &joint.name_of(quantity, k),
                    &format!("at most {most:.0}"),
                    values[row],
                )
                .hint(hint_of(hint)));
            }
        }
        if let Some(values) = joint.temperature
            && let Some(odd) = values.iter().find(|x| !(TEMPERATURES[0]..=TEMPERATURES[1]).contains(*x))
        {
            let name = joint.name_of(Quantity::Temperature, k);
            return Err(
                suspicious(&name, "from -60 to 250", *odd).hint("temperatures are in degrees Celsius")
            );
        }
        check_speed(recorded, joint, k)?;
        if let Some(range) = model.and_then(|model| model.joints().get(k)?.drive.range)
            && let Some(values) = joint.position
        {
            let margin = OUTSIDE * (range[1] - range[0]);
            if let Some(odd) = values.iter().find(|q| **q < range[0] - margin || **q > range[1] + margin) {
                let expected = format!("near the joint's range, {:.3} to {:.3}", range[0], range[1]);
                let name = joint.name_of(Quantity::Position, k);
                return Err(suspicious(&name, &expected, *odd).hint(hint_of("deg")));
            }
        }
    }
    check_currents(&recorded.joints)
}

fn suspicious(name: &str, expected: &str, found: f64) -> BadInput {
    BadInput::new(name, expected, format!("{found}"))
}

fn hint_of(unit: &str) -> String {
    format!(
        "is the unit {unit}? say so in the name of the column; --accept-units takes the numbers as they are"
    )
}

/// The slope of the coordinate's change over the speed is one.
fn check_speed(recorded: &Recorded, joint: &JointSeries, k: usize) -> Result<(), BadInput> {
    let (Some(q), Some(dq)) = (joint.position, joint.velocity) else { return Ok(()) };
    let (time, gap) = (recorded.time, recorded.gap);
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
    if correlation.abs() > CORRELATION && !(1.0 / SPEED_FACTOR..=SPEED_FACTOR).contains(&slope) {
        let name = joint.name_of(Quantity::Velocity, k);
        let found = format!("speeds with a slope of {slope:.3}");
        return Err(BadInput::new(name, "speeds that are the change of the coordinate", found)
            .hint(hint_of("another, or the sign of one of them")));
    }
    Ok(())
}

/// Currents are the part of the motors' currents at stall that duty cycles are, and moving motors need some. All joints together: one
/// of them may stand, be moved by hand, or have no sensor.
fn check_currents(joints: &[JointSeries]) -> Result<(), BadInput> {
    let bad = |expected: String, found: String, unit: &str| {
        Err(BadInput::new("current_*_a", expected, found).hint(hint_of(unit)))
    };
    let mean = |values: &[f64]| values.iter().map(|x| x.abs()).sum::<f64>() / values.len() as f64;
    let pairs = joints.iter().filter_map(|joint| Some((mean(joint.current?), mean(joint.pwm?))));
    let (current, pwm) = pairs
        .filter(|(current, pwm)| *current > 0.0 && *pwm > IDLE_PWM)
        .fold((0.0, 0.0), |sums, pair| (sums.0 + pair.0, sums.1 + pair.1));
    if pwm > 0.0 {
        let ([least, most], at_full) = (CURRENTS_AT_FULL_PWM, current / pwm);
        if !(least..=most).contains(&at_full) {
            let unit = if at_full < least { "a" } else { "ma" };
            let expected = format!("currents that make {least} to {most} A at full PWM");
            return bad(expected, format!("{at_full:.2e} A"), unit);
        }
    }
    let moving = |joint: &JointSeries| -> Option<Vec<f64>> {
        let rows = joint.current?.iter().zip(joint.velocity?);
        Some(rows.filter(|(i, dq)| **i != 0.0 && dq.abs() >= MOVING).map(|(i, _)| i.abs()).collect())
    };
    let mut moving: Vec<f64> = joints.iter().filter_map(moving).flatten().collect();
    moving.sort_by(f64::total_cmp);
    match moving.get(moving.len() / 2) {
        Some(median) if *median < SMALLEST_CURRENT => {
            let expected = format!("{SMALLEST_CURRENT} A or more in motors that move");
            bad(expected, format!("{median:.2e} A in the median"), "a")
        }
        _ => Ok(()),
    }
}
