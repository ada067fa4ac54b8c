//! Each kind of finding on a recording that has it alone, and none on its clean counterpart.
#![allow(clippy::unwrap_used)] // a test may stop where it stands

use super::*;
use crate::{Channel, Metadata, normal, rng};

const RATE: f64 = 100.0;
const N: usize = 2000;

/// A robot with three tendons 4 mm from its axis, 80 mm long, that bends in two directions; its tracker has a noise of 0.05 mm.
struct Robot {
    time: Vec<f64>,
    strokes: Vec<Vec<f64>>,
    tip: Vec<Vec<f64>>,
    gap: Vec<bool>,
    others: Vec<Channel>,
}

impl Robot {
    fn new(seed: u64) -> Self {
        let mut stream = rng(seed, "checks");
        let time: Vec<f64> = (0..N).map(|i| i as f64 / RATE).collect();
        let phase = 0.3 * seed as f64;
        let bend = |t: f64| [(1.9 * t + phase).sin(), (2.7 * t).cos() - 1.0];
        let stroke = |k: usize, t: f64| {
            let angle = std::f64::consts::TAU * k as f64 / 3.0;
            let [x, y] = bend(t);
            4e-3 * (x * angle.cos() + y * angle.sin())
        };
        let tip = |c: usize, t: f64| {
            let [x, y] = bend(t);
            [30e-3 * x, 30e-3 * y, 80e-3 - 6e-3 * (x * x + y * y)][c]
        };
        Self {
            strokes: (0..3).map(|k| time.iter().map(|t| stroke(k, *t)).collect()).collect(),
            tip: (0..3)
                .map(|c| time.iter().map(|t| tip(c, *t) + 5e-5 * normal(&mut stream)).collect())
                .collect(),
            gap: vec![false; N],
            time,
            others: Vec::new(),
        }
    }

    fn recording(&self) -> Recording {
        let mut channels = Vec::new();
        for (k, stroke) in self.strokes.iter().enumerate() {
            channels.push(Channel::new(format!("stroke_{}_m", k + 1), stroke.clone()));
        }
        for (axis, values) in ["x", "y", "z"].iter().zip(&self.tip) {
            channels.push(Channel::new(format!("tip_{axis}_m"), values.clone()));
        }
        channels.extend(self.others.iter().cloned());
        Recording::new(self.time.clone(), channels, self.gap.clone(), Metadata::default()).unwrap()
    }

    fn found(&self) -> Vec<Warning> {
        check_recording(&self.recording(), &CheckContext::new(Purpose::Fit))
    }

    /// The values so many rows later; before, they hardly move.
    fn late(values: &[f64], by: usize) -> Vec<f64> {
        (0..values.len()).map(|i| values[i.saturating_sub(by)] + 1e-6 * i.min(by) as f64).collect()
    }
}

/// An arm's joint that swings, with its speed.
fn arm(scale_q: f64, scale_dq: f64) -> Robot {
    let mut robot = Robot::new(1);
    let mut stream = rng(1, "arm");
    (robot.strokes, robot.tip) = (Vec::new(), Vec::new());
    let q = |t: &f64| scale_q * ((1.3 * t).sin() + 1e-4 * normal(&mut stream));
    let q = robot.time.iter().map(q).collect();
    let dq = robot.time.iter().map(|t| scale_dq * 1.3 * (1.3 * t).cos()).collect();
    robot.others = vec![Channel::new("q_1_rad", q), Channel::new("dq_1_rad_s", dq)];
    robot
}

/// The findings are this one alone, and it has a number beyond its limit and a hint.
fn assert_alone(found: &[Warning], kind: Finding, severity: Severity, channel: &str) {
    let shown: Vec<String> = found.iter().map(ToString::to_string).collect();
    assert_eq!(found.iter().map(|found| found.kind).collect::<Vec<_>>(), [kind], "{shown:#?}");
    let one = &found[0];
    assert_eq!((one.severity, one.channel.as_str()), (severity, channel), "{shown:#?}");
    assert!(!one.hint.is_empty() && one.value.is_finite() && one.limit.is_finite(), "{one:?}");
    assert!(one.value != one.limit, "{one:?}");
}

fn assert_warning(change: impl FnOnce(&mut Robot), kind: Finding, channel: &str) {
    let mut robot = Robot::new(1);
    change(&mut robot);
    assert_alone(&robot.found(), kind, Severity::Warning, channel);
}

fn refused(change: impl FnOnce(&mut Robot), kind: Finding, channel: &str) {
    let mut robot = Robot::new(1);
    change(&mut robot);
    assert_alone(&robot.found(), kind, Severity::Error, channel);
}

#[test]
fn clean_recordings_have_no_warnings() {
    for seed in 0..50 {
        let found = Robot::new(seed).found();
        assert!(found.is_empty(), "seed {seed}: {found:#?}");
    }
    assert_eq!(arm(1.0, 1.0).found(), []);
    let robots: Vec<Recording> = (0..5).map(|seed| Robot::new(seed).recording()).collect();
    let names = ["a", "b", "c", "d", "e"];
    let named: Vec<(&str, &Recording)> = names.into_iter().zip(&robots).collect();
    assert_eq!(check_recordings(&named, &CheckContext::new(Purpose::Fit)), []);
}

#[test]
fn stamps_in_another_unit_cause_warnings() {
    let scaled =
        |factor: f64| move |robot: &mut Robot| robot.time.iter_mut().for_each(|time| *time *= factor);
    assert_warning(scaled(1e3), Finding::TimeUnit, "time_s");
    assert_warning(scaled(1e-3), Finding::TimeUnit, "time_s");
}

#[test]
fn gaps_and_uneven_or_repeated_stamps_cause_warnings() {
    assert_warning(|robot| robot.gap[300..330].fill(true), Finding::Gap, "gap");
    assert_warning(|robot| robot.time[700..].iter_mut().for_each(|t| *t += 0.5), Finding::Gap, "time_s");
    let uneven = |robot: &mut Robot| {
        let mut stream = rng(3, "jitter");
        for time in &mut robot.time {
            *time += 0.0025 * normal(&mut stream).clamp(-1.9, 1.9);
        }
    };
    assert_warning(uneven, Finding::UnevenTime, "time_s");
    let repeated = |robot: &mut Robot| robot.time[500] = robot.time[499] + 1e-6;
    let mut robot = Robot::new(1);
    repeated(&mut robot);
    let found = robot.found();
    assert!(found.iter().any(|found| found.kind == Finding::RepeatedStamp && found.rows == Some([500, 501])));
}

#[test]
fn lengths_in_another_unit_cause_warnings_and_a_robot_of_60_m_is_refused() {
    let tip =
        |factor: f64| move |robot: &mut Robot| robot.tip.iter_mut().flatten().for_each(|x| *x *= factor);
    let strokes =
        |factor: f64| move |robot: &mut Robot| robot.strokes.iter_mut().flatten().for_each(|x| *x *= factor);
    refused(tip(1e3), Finding::Unit, "tip");
    assert_warning(tip(1e-3), Finding::Unit, "tip, strokes");
    assert_warning(tip(100.0), Finding::Unit, "tip");
    assert_warning(strokes(1e3), Finding::Unit, "strokes");
    assert_warning(strokes(1e-3), Finding::Unit, "tip, strokes");
}

#[test]
fn a_tip_beyond_the_body_is_refused() {
    let context = CheckContext { body_length: Some(0.02), ..CheckContext::new(Purpose::Fit) };
    let recording = Robot::new(1).recording();
    assert_alone(&check_recording(&recording, &context), Finding::Reach, Severity::Error, "tip_y_m");
    let context = CheckContext { body_length: Some(0.08), ..context };
    assert_eq!(check_recording(&recording, &context), []);
}

#[test]
fn frozen_tips_and_orientations_are_found() {
    refused(|robot| robot.tip.iter_mut().for_each(|axis| axis.fill(0.01)), Finding::Frozen, "tip");
    let stretch = |robot: &mut Robot| {
        robot.tip.iter_mut().for_each(|axis| {
            let held = axis[400];
            axis[400..480].fill(held);
        });
    };
    assert_warning(stretch, Finding::Frozen, "tip");
    let identity = |robot: &mut Robot| {
        for (name, value) in [("tip_qw", 1.0), ("tip_qx", 0.0), ("tip_qy", 0.0), ("tip_qz", 0.0)] {
            robot.others.push(Channel::new(name, vec![value; N]));
        }
    };
    assert_warning(identity, Finding::Frozen, "tip_qw … tip_qz");
    let zero = |robot: &mut Robot| {
        for name in ["tip_qw", "tip_qx", "tip_qy", "tip_qz"] {
            robot.others.push(Channel::new(name, vec![0.0; N]));
        }
    };
    refused(zero, Finding::Orientation, "tip_qw … tip_qz");
}

#[test]
fn held_and_repeated_rows_are_distinguished() {
    let held = |robot: &mut Robot| {
        for axis in &mut robot.tip {
            *axis = (0..N).map(|i| axis[i - i % 5]).collect();
        }
    };
    let mut robot = Robot::new(1);
    held(&mut robot);
    let found = robot.found();
    assert_alone(&found, Finding::SampleAndHold, Severity::Warning, "tip_x_m, tip_y_m, tip_z_m");
    assert_eq!(found[0].value, 5.0);
    let repeated = |robot: &mut Robot| {
        for row in (100..N).step_by(97) {
            robot.tip.iter_mut().for_each(|axis| axis[row] = axis[row - 1]);
        }
    };
    assert_warning(repeated, Finding::DuplicatedRow, "all measured");
}

#[test]
fn spikes_wraps_and_clipping_are_found_at_their_rows() {
    assert_warning(|robot| robot.tip[0][777] += 0.02, Finding::Spike, "tip_x_m");
    assert_warning(
        |robot| robot.tip[0][777..779].iter_mut().for_each(|x| *x += 0.02),
        Finding::Spike,
        "tip_x_m",
    );
    let mut turned = arm(1.0, 1.0);
    // The motion of a joint that turns on, and a sensor of one turn.
    let q: Vec<f64> = turned.time.iter().map(|t| (1.3 * t).rem_euclid(std::f64::consts::TAU)).collect();
    turned.others = vec![Channel::new("q_1_rad", q)];
    assert_alone(&turned.found(), Finding::Wrap, Severity::Warning, "q_1_rad");
    assert_warning(
        |robot| robot.tip[0].iter_mut().for_each(|x| *x = x.clamp(-0.02, 0.02)),
        Finding::Saturation,
        "tip_x_m",
    );
    assert_warning(
        |robot| robot.tip[1].iter_mut().for_each(|x| *x = (*x / 2e-3).round() * 2e-3),
        Finding::Quantisation,
        "tip_y_m",
    );
    let limited = |robot: &mut Robot| {
        let flags = (0..N).map(|i| if i < 200 { 1.0 } else { 0.0 });
        robot.others.push(Channel::new("limited", flags.collect()));
    };
    assert_warning(limited, Finding::Saturation, "limited");
}

#[test]
fn motion_that_turns_between_two_rows_is_no_spike() {
    // Rows 0.4 s apart, a peak of four rows every dozen: at each turn a row leaves its neighbours by as much as it does in a ramp.
    let slow = |robot: &mut Robot| {
        robot.time.iter_mut().for_each(|t| *t *= 40.0);
        let pull = |i: usize| 10e-3 * [0.0, 1.0, 2.0, 3.0, 2.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0][i % 12];
        for (i, x) in robot.tip[0].iter_mut().enumerate() {
            *x = pull(i) + 1e-5 * (i as f64).sin();
        }
    };
    let spikes = |robot: &Robot| {
        robot.found().into_iter().filter(|one| one.kind == Finding::Spike).collect::<Vec<_>>()
    };
    let mut robot = Robot::new(1);
    slow(&mut robot);
    assert_eq!(spikes(&robot), []);
    // Beyond three times the speed nearby no motion explains it.
    robot.tip[0][777] += 0.05;
    assert_eq!(spikes(&robot).len(), 1);
    // Holds in any order, each a rest of its own: neighbours have nothing in common, and their differences are no noise either.
    let mut stream = rng(3, "holds");
    let mut robot = Robot::new(1);
    robot.time.iter_mut().for_each(|t| *t *= 60.0);
    robot.tip.iter_mut().flatten().for_each(|x| *x = 0.05 * normal(&mut stream));
    let found = robot.found();
    let is_wrong = |one: &&Warning| one.kind == Finding::Spike || one.channel == "tip";
    assert_eq!(found.iter().filter(is_wrong).count(), 0, "{found:?}");
}

#[test]
fn a_servo_that_creeps_in_steps_of_its_encoder_repeats_no_rows_and_stops_at_no_end() {
    // A swing that comes to rest slowly at both ends, in steps of an encoder of 4096: rows that agree, and plateaus at the largest
    // value, into which single steps lead.
    let step = std::f64::consts::TAU / 4096.0;
    let mut robot = arm(1.0, 1.0);
    let swing = |t: f64| 0.02 * (0.6 * t).sin().clamp(-0.99, 0.99);
    let q: Vec<f64> = robot.time.iter().map(|t| (swing(*t) / step).round() * step).collect();
    robot.others = vec![Channel::new("q_1_rad", q)];
    let kinds: Vec<Finding> = robot.found().iter().map(|one| one.kind).collect();
    assert!(!kinds.contains(&Finding::DuplicatedRow) && !kinds.contains(&Finding::Saturation), "{kinds:?}");
}

#[test]
fn delays_are_estimated_to_a_few_milliseconds() {
    for by in [15, 23, 60] {
        let mut robot = Robot::new(2);
        robot.tip.iter_mut().for_each(|axis| *axis = Robot::late(axis, by));
        let found = robot.found();
        assert_alone(&found, Finding::Delay, Severity::Warning, "tip, strokes");
        // A third of a row: the tip is no linear function of the strokes.
        assert!((found[0].value - by as f64 / RATE).abs() < 0.3 / RATE, "{} for {by}", found[0].value);
    }
    let early = |robot: &mut Robot| robot.strokes.iter_mut().for_each(|s| *s = Robot::late(s, 6));
    assert_warning(early, Finding::Delay, "tip, strokes");
    // Five rows, 50 ms, are a servo and a tracker.
    let mut robot = Robot::new(2);
    robot.tip.iter_mut().for_each(|axis| *axis = Robot::late(axis, 5));
    assert_eq!(robot.found(), []);
}

#[test]
fn hysteresis_is_no_delay() {
    let mut robot = Robot::new(1);
    // Backlash of 0.4 mm in every tendon, by which the tip follows.
    let slack: Vec<Vec<f64>> = robot
        .strokes
        .iter()
        .map(|stroke| {
            let mut at = stroke[0];
            stroke
                .iter()
                .map(|s| {
                    at = at.clamp(s - 2e-4, s + 2e-4);
                    at
                })
                .collect()
        })
        .collect();
    let mut stream = rng(5, "noise");
    for i in 0..N {
        let [a, b, c] = [0, 1, 2].map(|k: usize| slack[k][i]);
        robot.tip[0][i] = 5.0 * (2.0 * a - b - c) + 5e-5 * normal(&mut stream);
        robot.tip[1][i] = 8.66 * (b - c) + 5e-5 * normal(&mut stream);
    }
    assert_eq!(robot.found(), []);
}

/// Strokes of four tendons on a square whose sides lie along them, as the plan `synthetic` has it: trapezoids that grow for 10 s, stay,
/// and shrink for 80 s, in metres.
fn square(period: f64, size: f64) -> Vec<Vec<f64>> {
    let corners = [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0], [1.0, 0.0]];
    let rise = |part: f64| 0.5 - 0.5 * (std::f64::consts::PI * part.clamp(0.0, 1.0)).cos();
    let point = |i: usize| {
        let t = i as f64 / RATE;
        let grown = size * rise(t / 10.0).min(rise((151.5 - t) / 80.0));
        let sides = 4.0 * (t / period).fract();
        let (side, part) = (sides as usize, sides.fract());
        let [x, y] = [0, 1].map(|c| corners[side][c] * (1.0 - part) + corners[side + 1][c] * part);
        // Turned by 45 degrees.
        [grown * (x - y) * 0.5_f64.sqrt(), grown * (x + y) * 0.5_f64.sqrt()]
    };
    let points: Vec<[f64; 2]> = (0..(155.0 * RATE) as usize).map(point).collect();
    let along = |c: usize, sign: f64| points.iter().map(|point| sign * point[c]).collect();
    vec![along(0, 1.0), along(1, 1.0), along(0, -1.0), along(1, -1.0)]
}

/// A tip that follows two crossed tendons behind a play, in metres, and `late` rows later.
fn behind_play(strokes: &[Vec<f64>], width: f64, late: usize, noise: f64) -> Robot {
    let mut stream = rng(7, "noise");
    let held = |values: &[f64]| {
        let mut at = values[0];
        values
            .iter()
            .map(|s| {
                at = at.clamp(s - 0.5 * width, s + 0.5 * width);
                at
            })
            .collect::<Vec<f64>>()
    };
    let mut axis = |k: usize| -> Vec<f64> {
        let tip = Robot::late(&held(&strokes[k]), late);
        tip.iter().map(|x| 4.0 * x + noise * normal(&mut stream)).collect()
    };
    let (x, y) = (axis(0), axis(1));
    let n = x.len();
    let time = (0..n).map(|i| i as f64 / RATE).collect();
    let tip = vec![x, y, vec![0.08; n]];
    Robot { time, strokes: strokes.to_vec(), tip, gap: vec![false; n], others: Vec::new() }
}

fn delay_of(robot: &Robot) -> Option<Warning> {
    robot.found().into_iter().find(|one| one.kind == Finding::Delay)
}

#[test]
fn a_robot_that_stands_while_its_tendons_are_slack_has_no_tracker_that_stopped() {
    // Slack is taken up, slowly and without a sound of the tracker: the tip rests, and goes on where it is.
    let strokes = square(13.0, 11e-3);
    let mut robot = behind_play(&strokes, 4e-3, 0, 0.0);
    // Until it does not move any more: nothing follows then that could tell.
    let n = 100 * RATE as usize;
    robot.tip.iter_mut().chain(&mut robot.strokes).for_each(|values| values.truncate(n));
    robot.time.truncate(n);
    robot.gap.truncate(n);
    let still = |robot: &Robot| robot.found().into_iter().find(|one| one.kind == Finding::Frozen);
    let rests = (1..robot.time.len()).filter(|i| (0..2).all(|c| robot.tip[c][*i] == robot.tip[c][i - 1]));
    assert!(rests.count() > 500);
    assert_eq!(still(&robot), None);
    // The same, and a tracker that repeats a pose for two seconds and then shows where the tip has gone.
    let mut stopped = robot;
    stopped.tip.iter_mut().for_each(|axis| (4001..4200).for_each(|i| axis[i] = axis[4000]));
    assert!(still(&stopped).is_some_and(|one| one.value > 1.9));
}

#[test]
fn play_on_a_square_is_no_delay() {
    for period in [10.0, 13.0, 20.0] {
        let strokes = square(period, 11e-3);
        for width in [0.0, 0.2e-3, 0.5e-3, 1e-3, 2e-3, 4e-3] {
            for noise in [0.0, 5e-5] {
                let found = delay_of(&behind_play(&strokes, width, 0, noise));
                assert!(found.is_none(), "{period} s, {width} m, {noise}: {found:?}");
            }
        }
    }
}

#[test]
fn a_delay_is_found_next_to_play() {
    let strokes = square(13.0, 11e-3);
    for width in [0.0, 0.5e-3, 2e-3] {
        let delay = delay_of(&behind_play(&strokes, width, 30, 5e-5));
        // Of which play looks like a part.
        let limits = 0.27..0.33 + 2e2 * width;
        assert!(delay.as_ref().is_some_and(|delay| limits.contains(&delay.value)), "{width} m: {delay:?}");
    }
}

#[test]
fn copies_are_found_in_others_and_within() {
    let [train, other] = [1, 2].map(|seed| Robot::new(seed).recording());
    let mut mixed = Robot::new(3);
    let copied = Robot::new(1);
    for (to, from) in mixed.tip.iter_mut().zip(&copied.tip) {
        to[900..1300].copy_from_slice(&from[200..600]);
    }
    let mixed = mixed.recording();
    let context = CheckContext::new(Purpose::Score);
    let copies = |named: &[(&str, &Recording)]| -> Vec<Warning> {
        let found = check_recordings(named, &context);
        found.into_iter().filter(|found| found.kind == Finding::CopyOfRecording).collect()
    };
    let found = copies(&[("train", &train), ("other", &other), ("test", &train)]);
    assert_alone(&found, Finding::CopyOfRecording, Severity::Warning, "all measured");
    assert_eq!((found[0].recording.as_str(), found[0].value), ("test", 100.0));
    assert_eq!(found[0].rows.map(|[_, last]| last > N - 64), Some(true));
    let found = copies(&[("train", &train), ("test", &mixed)]);
    assert_alone(&found, Finding::CopyOfRecording, Severity::Warning, "all measured");
    // Of 1937 stretches 337 are copied, an eighth of them kept.
    assert!((found[0].value - 17.4).abs() < 8.0, "{}", found[0].value);
    assert_eq!(copies(&[("train", &train), ("test", &other)]), []);

    let mut twice = Robot::new(4);
    for axis in twice.tip.iter_mut().chain(&mut twice.strokes) {
        let (first, second) = axis.split_at_mut(N / 2);
        second.copy_from_slice(first);
    }
    let found = twice.found();
    assert!(
        found
            .iter()
            .any(|found| found.kind == Finding::CopyWithin && found.rows.is_some_and(|rows| rows[0] > N / 2))
    );
}

#[test]
fn tendons_that_are_not_pulled_or_only_together_are_found() {
    let idle = |robot: &mut Robot| robot.strokes.push(vec![0.0; N]);
    assert_warning(idle, Finding::Tendon, "stroke_4_m");
    let together = |robot: &mut Robot| {
        let mut stream = rng(1, "together");
        for i in 0..N {
            let pull = 4e-3 * (1.9 * robot.time[i]).sin();
            robot.strokes.iter_mut().for_each(|stroke| stroke[i] = pull);
            robot.tip[0][i] = 5e-5 * normal(&mut stream);
            robot.tip[1][i] = 5e-5 * normal(&mut stream);
            robot.tip[2][i] = 0.08 - pull + 5e-5 * normal(&mut stream);
        }
    };
    assert_warning(together, Finding::Tendon, "strokes");
    // What one recording leaves out another has.
    let single = |k: usize| {
        let mut robot = Robot::new(k as u64);
        robot
            .strokes
            .iter_mut()
            .enumerate()
            .filter(|(j, _)| *j != k)
            .for_each(|(_, stroke)| stroke.fill(0.0));
        robot.recording()
    };
    let recordings = [0, 1, 2].map(single);
    let named: Vec<(&str, &Recording)> = ["a", "b", "c"].into_iter().zip(&recordings).collect();
    let found = check_recordings(&named, &CheckContext::new(Purpose::Fit));
    assert!(!found.iter().any(|found| found.kind == Finding::Tendon), "{found:#?}");
}

#[test]
fn too_little_motion_is_found_where_something_is_fitted() {
    let once = |robot: &mut Robot| {
        let mut stream = rng(1, "once");
        for i in 0..N {
            let bend = [robot.time[i] / 20.0, (robot.time[i] / 20.0).powi(2)];
            for k in 0..3 {
                let angle = 2.1 * k as f64;
                robot.strokes[k][i] = 4e-3 * (bend[0] * angle.cos() + bend[1] * angle.sin());
            }
            for c in 0..3 {
                robot.tip[c][i] = 30e-3 * bend[c % 2] + 5e-5 * normal(&mut stream);
            }
        }
    };
    assert_warning(once, Finding::Excitation, "strokes");
    let mut robot = Robot::new(1);
    once(&mut robot);
    assert_eq!(check_recording(&robot.recording(), &CheckContext::new(Purpose::Score)), []);
    let noisy = |robot: &mut Robot| {
        let mut stream = rng(9, "noise");
        robot.tip.iter_mut().flatten().for_each(|x| *x += 6e-3 * normal(&mut stream));
    };
    assert_warning(noisy, Finding::Excitation, "tip");
}

#[test]
fn wrong_units_of_joints_cause_warnings() {
    let degrees = 180.0 / std::f64::consts::PI;
    let found = arm(degrees, degrees).found();
    assert_eq!(found[0].kind, Finding::Unit);
    assert_alone(&arm(0.5, 0.5 * degrees).found(), Finding::Speed, Severity::Warning, "dq_1_rad_s");
    assert_alone(&arm(1.0, -1.0).found(), Finding::Speed, Severity::Warning, "dq_1_rad_s");
    assert_alone(
        &arm(1.0, 60.0 / std::f64::consts::TAU).found(),
        Finding::Speed,
        Severity::Warning,
        "dq_1_rad_s",
    );
    assert_alone(&arm(1e-3, 1e-3).found(), Finding::Excitation, Severity::Warning, "q_1_rad");
    let range = [Some([-0.2, 0.2])];
    let context = CheckContext { joint_ranges: &range, ..CheckContext::new(Purpose::Fit) };
    let found = check_recording(&arm(1.0, 1.0).recording(), &context);
    assert_alone(&found, Finding::Unit, Severity::Warning, "q_1_rad");
}

#[test]
fn a_short_recording_is_not_judged() {
    let recording = Recording::new(
        vec![0.0, 1.0, 1e6],
        vec![Channel::new("tip_x_m", vec![0.0, 1e3, 0.0])],
        Vec::new(),
        Metadata::default(),
    );
    assert_eq!(check_recording(&recording.unwrap(), &CheckContext::new(Purpose::Fit)), []);
}
