//! The shape of a robot's response to a command: amplitude, roundness, return error.
//!
//! A robot's tip is laid over the commanded points of tendon space by one factor, the best in the sense of least
//! squares. What then differs is the robot: slack and friction draw a circle towards a diamond on the tendon axes
//! (CoReAct paper, Fig. 2), and friction keeps it from returning to where it rested.

use hysteron_base::{BadInput, Recording};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// Rest is at most so long at both ends of a recording [s] …
const REST_S: f64 = 0.5;
/// … and there the command is at most this part of its largest [-].
const REST_PART: f64 = 0.01;
/// Where the command is smaller than this part of its largest, noise decides the direction of the tip [-].
const LARGE_PART: f64 = 0.5;
/// Equal angles in which radii are averaged; 8 for each sector of 45°.
const N_BINS: usize = 64;

/// Command and tip over each other.
#[derive(Debug, Clone, PartialEq)]
pub struct HysteresisShape {
    /// Commanded points (a, b) of tendon space (n_samples) [m].
    pub command: Vec<[f64; 2]>,
    /// Tip in x and y from where it rested at the beginning (n_samples) [m].
    pub tip: Vec<[f64; 2]>,
    /// Figures of the shape.
    pub numbers: ShapeNumbers,
}

/// Numbers of a shape.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ShapeNumbers {
    /// Largest distance of the tip from rest, in x and y [m].
    pub excursion_m: f64,
    /// Factor from command to tip, fitted to all samples [-].
    pub tip_per_stroke: f64,
    /// Distance of the tip over that of the command, its mean within 22.5° of the diagonals over its mean within
    /// 22.5° of the axes x and y, each direction counting the same [-]. 1 for the shape that was commanded; for a
    /// circle that became the diamond |x| + |y| = c it is 0.843. `None` where the tip does not go all around.
    pub diamond_ratio: Option<f64>,
    /// Distance of the tip at rest in the end from that at the beginning, over the excursion [-].
    pub return_error: f64,
}

impl HysteresisShape {
    /// Shape of a recording with strokes and a tip, for tendons at these angles [rad] about z.
    ///
    /// # Errors
    /// `BadInput` if a channel is missing, if the angles are not those of the strokes or pull in one line only, or
    /// if nothing moves.
    pub fn of(recording: &Recording, angles: &[f64]) -> Result<Self, BadInput> {
        let command = tendon_space(recording, angles)?;
        let (x, y) = (recording.require("tip_x_m")?, recording.require("tip_y_m")?);
        let distance = |[a, b]: [f64; 2]| a.hypot(b);
        let largest = command.iter().map(|point| distance(*point)).fold(0.0, f64::max);
        let is_rest = |i: &usize| distance(command[*i]) <= REST_PART * largest;
        let time = recording.time();
        let last = time.len() - 1;
        let first_rows = (0..=last).take_while(|&i| time[i] - time[0] <= REST_S).filter(is_rest);
        let last_rows = (0..=last).rev().take_while(|&i| time[last] - time[i] <= REST_S).filter(is_rest);
        let rest = mean(x, y, first_rows, 0);
        let end = mean(x, y, last_rows, last);

        let tip: Vec<[f64; 2]> = x.iter().zip(y).map(|(x, y)| [x - rest[0], y - rest[1]]).collect();
        let excursion_m = tip.iter().map(|point| distance(*point)).fold(0.0, f64::max);
        if largest == 0.0 || excursion_m == 0.0 {
            let found = if largest == 0.0 { "no command" } else { "a tip at rest" };
            return Err(BadInput::new("recording", "strokes that move the tip", found));
        }
        let dot = |a: &[f64; 2], b: &[f64; 2]| a[0] * b[0] + a[1] * b[1];
        let both: f64 = command.iter().zip(&tip).map(|(a, b)| dot(a, b)).sum();
        let own: f64 = command.iter().map(|a| dot(a, a)).sum();
        let numbers = ShapeNumbers {
            excursion_m,
            tip_per_stroke: both / own,
            diamond_ratio: diamond_ratio(&command, &tip, LARGE_PART * largest),
            return_error: distance([end[0] - rest[0], end[1] - rest[1]]) / excursion_m,
        };
        Ok(Self { command, tip, numbers })
    }
}

/// Commanded points (a, b) of tendon space (n_samples) [m]: those whose strokes, a cos φ + b sin φ, are nearest to
/// the recorded ones. What all tendons have in common drops out where they are evenly around the body.
fn tendon_space(recording: &Recording, angles: &[f64]) -> Result<Vec<[f64; 2]>, BadInput> {
    let strokes = recording.strokes();
    if strokes.len() != angles.len() {
        let expected = format!("{} strokes, one per tendon", angles.len());
        return Err(BadInput::new("recording", expected, strokes.len().to_string()));
    }
    // Normal equations of the least squares, 2 × 2.
    let [mut cc, mut cs, mut ss] = [0.0; 3];
    for (sin, cos) in angles.iter().map(|angle| angle.sin_cos()) {
        cc += cos * cos;
        cs += cos * sin;
        ss += sin * sin;
    }
    let det = cc * ss - cs * cs;
    if det.is_nan() || det < 1e-6 {
        return Err(BadInput::new(
            "tendon angles",
            "tendons that bend in two directions",
            format!("{angles:?}"),
        ));
    }
    let point = |i: usize| {
        let [mut c, mut s] = [0.0; 2];
        for (stroke, angle) in strokes.iter().zip(angles) {
            c += angle.cos() * stroke[i];
            s += angle.sin() * stroke[i];
        }
        [(ss * c - cs * s) / det, (cc * s - cs * c) / det]
    };
    Ok((0..recording.n_samples()).map(point).collect())
}

/// Mean point of these rows, or that of `otherwise` if there are none.
fn mean(x: &[f64], y: &[f64], rows: impl Iterator<Item = usize>, otherwise: usize) -> [f64; 2] {
    let (mut sum, mut n) = ([0.0; 2], 0.0);
    for i in rows {
        sum = [sum[0] + x[i], sum[1] + y[i]];
        n += 1.0;
    }
    if n == 0.0 { [x[otherwise], y[otherwise]] } else { [sum[0] / n, sum[1] / n] }
}

/// See [`ShapeNumbers::diamond_ratio`]; samples whose command is smaller than `least` [m] do not count.
fn diamond_ratio(command: &[[f64; 2]], tip: &[[f64; 2]], least: f64) -> Option<f64> {
    let (mut sums, mut counts) = ([0.0; N_BINS], [0.0; N_BINS]);
    for (command, tip) in command.iter().zip(tip) {
        let size = command[0].hypot(command[1]);
        if size >= least {
            let turns = tip[1].atan2(tip[0]) / TAU;
            let bin = ((turns.rem_euclid(1.0) * N_BINS as f64) as usize).min(N_BINS - 1);
            sums[bin] += tip[0].hypot(tip[1]) / size;
            counts[bin] += 1.0;
        }
    }
    if counts.contains(&0.0) {
        return None;
    }
    // Eight sectors of eight bins, in turn around an axis and around a diagonal; the first axis is in the middle
    // of its sector.
    let mut radii = [0.0; 2];
    for bin in 0..N_BINS {
        let sector = (bin + N_BINS / 16) / (N_BINS / 8);
        radii[sector % 2] += sums[bin] / counts[bin];
    }
    Some(radii[1] / radii[0])
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test may stop where it stands
    use super::*;
    use crate::MotionPlan;
    use hysteron_base::{Channel, Metadata};

    /// Angles of four tendons evenly around the body [rad].
    const ANGLES: [f64; 4] = [0.0, 0.25 * TAU, 0.5 * TAU, 0.75 * TAU];

    /// The commands of a trajectory of the plan `quick`, with this tip for every commanded point.
    fn recorded(name: &str, tip_of: impl Fn([f64; 2]) -> [f64; 2]) -> Recording {
        let plan = MotionPlan::named("quick").unwrap();
        let trajectory = plan.trajectories().iter().find(|trajectory| trajectory.name == name).unwrap();
        let commands = trajectory.commands().unwrap();
        let tips: Vec<[f64; 2]> =
            commands.time().iter().map(|t| tip_of(trajectory.position_at(*t))).collect();
        let mut channels = commands.channels().to_vec();
        channels.push(Channel::new("tip_x_m", tips.iter().map(|tip| tip[0]).collect()));
        channels.push(Channel::new("tip_y_m", tips.iter().map(|tip| tip[1]).collect()));
        Recording::new(commands.time().to_vec(), channels, vec![], Metadata::default()).unwrap()
    }

    fn shape(name: &str, tip_of: impl Fn([f64; 2]) -> [f64; 2]) -> HysteresisShape {
        HysteresisShape::of(&recorded(name, tip_of), &ANGLES).unwrap()
    }

    #[test]
    fn a_tip_that_follows_has_the_shape_of_the_command() {
        for name in ["circle", "square", "sinusoid", "diagonal", "ellipse"] {
            let HysteresisShape { numbers, command, tip } =
                shape(name, |[a, b]| [5.0 * a + 0.3, 5.0 * b - 0.1]);
            let amplitude = if name == "ellipse" { 4.2e-3 } else { 4.5e-3 };
            assert!((numbers.excursion_m - 5.0 * amplitude).abs() < 2e-4 * amplitude, "{name} {numbers:?}");
            assert!((numbers.tip_per_stroke - 5.0).abs() < 1e-3, "{name} {numbers:?}");
            assert!(numbers.return_error < 0.02, "{name} {numbers:?}");
            let goes_around = !["sinusoid", "diagonal"].contains(&name);
            assert_eq!(numbers.diamond_ratio.is_some(), goes_around, "{name}");
            if let Some(ratio) = numbers.diamond_ratio {
                assert!((ratio - 1.0).abs() < 2e-2, "{name} {ratio}");
            }
            for (command, tip) in command.iter().zip(tip) {
                assert!((5.0 * command[0] - tip[0]).abs() < 2e-4, "{name}");
            }
        }
    }

    /// Circles at even speed around a rest that is visited first and last.
    fn rounds(tip_of: impl Fn(f64) -> [f64; 2], miss: [f64; 2]) -> ShapeNumbers {
        let n = 20_000;
        let angle = |i: usize| 0.003 * i as f64;
        let is_rest = |i: usize| !(100..n - 100).contains(&i);
        let time: Vec<f64> = (0..n).map(|i| 0.01 * i as f64).collect();
        let stroke = |k: usize| {
            (0..n).map(|i| if is_rest(i) { 0.0 } else { (angle(i) - TAU / 4.0 * k as f64).cos() }).collect()
        };
        let mut channels: Vec<Channel> =
            (0..4).map(|k| Channel::new(format!("stroke_{}_m", k + 1), stroke(k))).collect();
        for (c, name) in ["tip_x_m", "tip_y_m"].into_iter().enumerate() {
            let rest = |i: usize| if i < n / 2 { 0.0 } else { miss[c] };
            let values = (0..n).map(|i| if is_rest(i) { rest(i) } else { tip_of(angle(i))[c] });
            channels.push(Channel::new(name, values.collect()));
        }
        let recording = Recording::new(time, channels, vec![], Metadata::default()).unwrap();
        HysteresisShape::of(&recording, &ANGLES).unwrap().numbers
    }

    #[test]
    fn circle_and_diamond_have_their_ratios() {
        let circle = rounds(|angle| [2.0 * angle.cos(), 2.0 * angle.sin()], [0.0; 2]);
        assert!((circle.diamond_ratio.unwrap() - 1.0).abs() < 1e-12, "{circle:?}");
        assert!((circle.tip_per_stroke - 2.0).abs() < 1e-12);
        assert_eq!(circle.return_error, 0.0);
        let diamond = rounds(
            |angle| {
                let size = 3.0 / (angle.cos().abs() + angle.sin().abs());
                [size * angle.cos(), size * angle.sin()]
            },
            [0.3, -0.4],
        );
        // Radius c / (√2 cos β) at the angle β from the diagonal: its integral is that of 1 / cos, artanh(sin β).
        let integral = |from: f64, to: f64| to.sin().atanh() - from.sin().atanh();
        let eighth = TAU / 16.0;
        let expected = integral(0.0, eighth) / integral(eighth, 2.0 * eighth);
        assert!((expected - 0.8432).abs() < 1e-4, "{expected}");
        assert!((diamond.diamond_ratio.unwrap() - expected).abs() < 1e-3, "{diamond:?}");
        assert!((diamond.excursion_m - 3.0).abs() < 1e-2);
        assert!((diamond.return_error - 0.5 / diamond.excursion_m).abs() < 1e-12);
    }

    #[test]
    fn common_pull_drops_out_and_uneven_angles_are_solved_for() {
        let angles = [0.2_f64, 1.9, 4.0];
        let strokes = angles.map(|angle| 3e-3 * angle.cos() - 1e-3 * angle.sin());
        let channels = strokes.iter().enumerate();
        let channels =
            channels.map(|(k, stroke)| Channel::new(format!("stroke_{}_m", k + 1), vec![*stroke])).collect();
        let recording = Recording::new(vec![0.0], channels, vec![], Metadata::default()).unwrap();
        let [a, b] = tendon_space(&recording, &angles).unwrap()[0];
        assert!((a - 3e-3).abs() < 1e-15 && (b + 1e-3).abs() < 1e-15, "{a} {b}");
        let common = (1..=4).map(|k| Channel::new(format!("stroke_{k}_m"), vec![1e-3])).collect();
        let recording = Recording::new(vec![0.0], common, vec![], Metadata::default()).unwrap();
        let [a, b] = tendon_space(&recording, &ANGLES).unwrap()[0];
        assert!(a.abs() < 1e-18 && b.abs() < 1e-18, "{a} {b}");
    }

    #[test]
    fn what_has_no_shape_is_refused() {
        let whole = recorded("circle", |point| point);
        let reject = |recording: &Recording, angles: &[f64], found: &str| {
            assert_eq!(HysteresisShape::of(recording, angles).unwrap_err().found, found);
        };
        reject(&whole, &ANGLES[..3], "4");
        reject(&whole, &[0.0; 4], "[0.0, 0.0, 0.0, 0.0]");
        reject(&recorded("circle", |_| [1.0, 1.0]), &ANGLES, "a tip at rest");
        let without = |name: &str, zero: bool| {
            let channels = whole.channels().iter().filter(|channel| channel.name != name).map(|channel| {
                let is_stroke = channel.name.starts_with("stroke");
                let values =
                    if zero && is_stroke { vec![0.0; whole.n_samples()] } else { channel.values.clone() };
                Channel::new(&channel.name, values)
            });
            Recording::new(whole.time().to_vec(), channels.collect(), vec![], Metadata::default()).unwrap()
        };
        reject(&without("", true), &ANGLES, "no command");
        assert_eq!(
            HysteresisShape::of(&without("tip_y_m", false), &ANGLES).unwrap_err().expected,
            "a channel tip_y_m"
        );
    }
}
