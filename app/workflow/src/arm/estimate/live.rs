//! `hysteron arm estimate --live`: estimates while a follower follows its leader.
//!
//! The arm is driven and guarded as by `hysteron arm record`, and nothing is sent that the leader did not ask for. Each row goes through
//! the estimator before the next cycle begins, and its estimates are further channels of the recording.

use std::cell::RefCell;
use std::path::Path;
use std::time::Instant;

use hysteron_arm_learning::neural::{ContactEstimate, LiveEstimator, NeuralActuator, ServoTelemetry};
use hysteron_base::BadInput;
use hysteron_rig::bus::model::EffortRegister;
use hysteron_rig::session::Histogram;
use hysteron_rig::teleoperation::{ArmsConfig, Estimates};

use super::Options;
use super::channels::{names, values};
use super::outcome::{LiveEstimates, TimePercentiles};
use crate::Context;
use crate::arm::record;

/// How far the rate of the bus may be from that of the actuator, as a part of it.
const MAX_RATE_OFF: f64 = 0.1;
/// Measured quantities of every motor in a row: q, goal, dq, current, voltage, temperature, pwm.
const QUANTITIES: usize = 7;

/// State of the estimation row by row, with its computing times.
struct LiveEstimation<'m> {
    estimator: LiveEstimator<'m>,
    motors: usize,
    /// Latest measured row; a servo that did not answer keeps its last values.
    latest: Vec<f64>,
    rows: u64,
    contacts: u64,
    /// Contacts that began.
    begun: u64,
    last: Option<ContactEstimate>,
    /// Times of a step.
    times: Histogram,
}

impl LiveEstimation<'_> {
    /// Takes a row as it was measured and appends the estimates: none before every servo has answered once.
    fn append(&mut self, row: &mut Vec<f64>) {
        let start = Instant::now();
        if self.latest.is_empty() {
            self.latest.resize(row.len(), f64::NAN);
        }
        let measured = self.latest.iter_mut().zip(row.iter());
        measured.filter(|(_, now)| now.is_finite()).for_each(|(latest, now)| *latest = *now);
        let m = self.motors;
        if self.latest.iter().any(|value| value.is_nan()) {
            row.extend(std::iter::repeat_n(f64::NAN, m + 5));
            return;
        }
        let of = |quantity: usize| &self.latest[quantity * m..][..m];
        let now = self.estimator.update(&ServoTelemetry {
            position: of(0),
            goal: of(1),
            velocity: of(2),
            current: of(3),
            voltage: of(4),
            temperature: of(5),
            pwm: of(6),
            goal_aperture: self.latest.get(QUANTITIES * m + 1).copied().unwrap_or(0.0),
        });
        row.extend(values(self.estimator.torque(), &now));
        let is_contact = now.gate >= 0.5;
        self.begun += u64::from(is_contact && self.last.is_none_or(|last| last.gate < 0.5));
        self.contacts += u64::from(is_contact);
        self.rows += 1;
        self.last = Some(now);
        self.times.add(start.elapsed().as_secs_f64());
    }
}

/// Estimates on a bus.
///
/// # Errors
/// Bad input; arms that do not answer; a limit that was passed.
pub(super) fn run(
    (options, arms): (&Options, &Path),
    actuator: &NeuralActuator,
    estimator: LiveEstimator<'_>,
    context: &Context,
) -> anyhow::Result<LiveEstimates> {
    let config = ArmsConfig::read(arms)?;
    check(&config, actuator).map_err(|bad| bad.within(arms.display()))?;
    let motors = actuator.features.motors();
    let estimator = estimator.with_position_gain(Some(f64::from(config.follower.gains[0])))?;
    let live = RefCell::new(LiveEstimation {
        estimator,
        motors,
        latest: Vec::new(),
        rows: 0,
        contacts: 0,
        begun: 0,
        last: None,
        times: Histogram::new(),
    });
    let estimates = Estimates { names: names(motors), append: Box::new(|row| live.borrow_mut().append(row)) };
    let recording = record::Options {
        arms: arms.to_owned(),
        out: options.out.clone(),
        seconds: options.seconds,
        payload_g: 0.0,
        degraded: false,
    };
    let outcome = record::record((&recording, &config), estimates, context);
    let live = live.into_inner();
    let ages = outcome.as_ref().map(|outcome| outcome.ages.clone()).unwrap_or_default();
    report(&live, (&ages, config.period), context);
    let record::Outcome { recording, rows, filled_in, late_cycles } = record::summary(&outcome?, context);
    Ok(LiveEstimates {
        recording,
        rows,
        filled_in,
        late_cycles,
        rate_hz: 1.0 / config.period,
        contact: live.contacts as f64 / live.rows.max(1) as f64,
        contacts: live.begun,
        healthy_at_end: live.last.map(|now| now.condition),
        step_ms: percentiles(&live.times),
        age_ms: percentiles(&ages),
        held_joints: Vec::new(),
    })
}

/// Percentiles of times [ms].
fn percentiles(times: &Histogram) -> TimePercentiles {
    TimePercentiles {
        median: 1e3 * times.percentile(0.5),
        p95: 1e3 * times.percentile(0.95),
        p99: 1e3 * times.percentile(0.99),
        max: 1e3 * times.max(),
    }
}

/// Says what was estimated, and how long it took.
fn report(live: &LiveEstimation<'_>, (ages, period): (&Histogram, f64), context: &Context) {
    let Some(now) = &live.last else { return };
    let [x, y, z] = now.force;
    context.print(format_args!(
        "estimates: {} samples at {:.0} Hz, {} contacts, {:.1} % of the time; at the end force ({x:.2}, {y:.2}, {z:.2}) N, healthy {:.3}",
        live.rows,
        1.0 / period,
        live.begun,
        100.0 * live.contacts as f64 / live.rows as f64,
        now.condition
    ));
    let line = |name: &str, times: &Histogram| {
        let [half, most, nearly_all] = [0.5, 0.95, 0.99].map(|part| 1e3 * times.percentile(part));
        context.print(format_args!(
            "{name}: median {half:.2} ms, 95 % {most:.2} ms, 99 % {nearly_all:.2} ms, longest {:.2} ms",
            1e3 * times.max()
        ));
    };
    line("a step of the estimator", &live.times);
    line("from reading the servos to the estimate", ages);
}

/// Refuses arms that are not the actuator's.
fn check(config: &ArmsConfig, actuator: &NeuralActuator) -> Result<(), BadInput> {
    let features = &actuator.features;
    let found: Vec<&str> = config.joints.iter().map(|joint| joint.name.as_str()).collect();
    let is_same = found.len() == features.motors()
        && found.iter().zip(&actuator.joints).all(|(found, own)| found == own)
        && config.gripper.is_some() == features.gripper.is_some();
    if !is_same {
        let gripper = if features.gripper.is_some() { ", and a gripper" } else { ", without a gripper" };
        let expected = format!("joints {}{gripper}", actuator.joints.join(", "));
        return Err(BadInput::new("joint", expected, found.join(", "))
            .hint("the actuator was trained on another arm"));
    }
    let no_current = config.joints.iter().find(|joint| joint.follower.model.effort == EffortRegister::Load);
    if let Some(joint) = no_current {
        let found = format!("{} in {}", joint.follower.model.name, joint.name);
        return Err(BadInput::new("follower", "servos that measure their current", found));
    }
    let (own, found) = (1.0 / actuator.simulation.period, 1.0 / config.period);
    if (found / own - 1.0).abs() > MAX_RATE_OFF {
        let expected = format!("{own:.1} Hz, as the actuator was trained, within 10 %");
        return Err(BadInput::new("rate_hz", expected, format!("{found:.1} Hz")));
    }
    Ok(())
}
