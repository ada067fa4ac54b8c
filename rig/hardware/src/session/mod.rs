//! A session: from torque on to torque off, which always follows.
//!
//! Every motion is a sequence of cycles at a fixed rate; a cycle commands, reads and checks. A cycle that fails, or
//! finds a limit passed that forbids to move on, switches the torque off before it returns. A [`RigSession`] that is
//! dropped, by an error or a panic alike, switches it off too: it is only held, if the rig file sets it, after a
//! run that came to its end. Against the death of this very process there are two further guards: the program's
//! watchdog process, which switches the torque off in its place, and the servos' own watchdog, which stops them when
//! the bus falls silent.

mod align;
mod cycle;
mod feedback;
mod hold;
mod record;
mod stats;
mod supervisor;

use crate::calibration::RigCalibration;
use crate::config::{AtEnd, RigConfig, TrackerSource};
use crate::tracker::Registration;
use crate::{
    Error, Event, EventKind, Hardware, Pose, Result, ServoSample, ShutdownAction, SlowSample, Violation,
};
pub use feedback::{FEEDBACK_GATE, TipFeedback, response_channel};
use hold::LoadGuard;
pub use record::{Outcome, RecordOptions, RigRecorder, events_path, free_name, journal_path, recover};
pub(crate) use record::{convert, disk, line_of};
pub use stats::{Histogram, RunStats, StatsSummary, TemperatureHistory};
pub use supervisor::Supervisor;

/// Cycles without an answer after which a servo counts as lost.
const LOST_AFTER: u32 = 5;
/// Voltage and temperature are read once in so many cycles, out of turn with the rest.
const SLOW_EVERY: u64 = 50;
/// How long to retry torque off for servos that do not answer [s].
const RELEASE_PATIENCE: f64 = 3.0;
/// Pause between these tries [s].
const RELEASE_PAUSE: f64 = 0.05;
/// Time that the robot is left at rest before a run [s].
const SETTLE: f64 = 0.5;

/// By how much a tendon can be moved while the tip stays where it is [m]: play and slack of tendons that were set by
/// hand are some tenths of a millimetre, and the others move, too.
const LOST_MOTION: f64 = 2e-3;
/// By how much a stroke may be beyond its limits before a run [m]: a tendon without torque unwinds a little.
const START_MARGIN: f64 = 2e-3;

/// Why a motion did not come to its end.
#[derive(Debug)]
pub enum Stop {
    /// A limit was passed.
    Limit(Violation),
    /// The rig failed.
    Failed(Error),
    /// Somebody asked to stop.
    Asked,
}

impl std::fmt::Display for Stop {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Limit(violation) => write!(f, "limit passed: {violation}"),
            Self::Failed(error) => write!(f, "{error}"),
            Self::Asked => write!(f, "interrupted"),
        }
    }
}

impl Stop {
    /// Whether the servos must not be driven any more, not even back to rest.
    fn forbids_motion(&self) -> bool {
        match self {
            Self::Limit(violation) => violation.shutdown == ShutdownAction::TorqueOff,
            Self::Failed(_) => true,
            Self::Asked => false,
        }
    }
}

/// Whether the servos of a session drive their motors.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Torque {
    /// They do.
    On,
    /// The session has ended, and left the torque as it shall be.
    Settled,
    /// The session has ended, and could not reach the servos.
    Unreachable,
}

/// Torque at the end of a session.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum TorqueAtEnd {
    /// Switched off.
    Off,
    /// As in the rig file: the run came to its end.
    AsConfigured,
}

impl From<Violation> for Stop {
    fn from(violation: Violation) -> Self {
        Self::Limit(violation)
    }
}

impl From<Error> for Stop {
    fn from(error: Error) -> Self {
        Self::Failed(error)
    }
}

/// A tip whose pose stays the same to the last bit.
#[derive(Debug, Clone)]
struct FrozenPose {
    pose: Pose,
    /// Strokes measured at first (n) [m].
    strokes: Vec<f64>,
    /// Whether it was logged that it must have moved.
    is_logged: bool,
}

/// A rig under torque.
pub struct RigSession<'a> {
    hardware: &'a mut dyn Hardware,
    rig: &'a RigConfig,
    /// With its zeros in the turns that the servos count now.
    pub calibration: RigCalibration,
    /// Time of a cycle [s].
    period: f64,
    /// When the next cycle begins, on the rig's clock [s].
    next: f64,
    /// To which time the last cycle belongs, on the rig's clock [s].
    cycle_time: f64,
    /// Strokes commanded last (n) [m].
    commanded: Vec<f64>,
    goals: Vec<i32>,
    /// Strokes to command next (n) [m].
    target: Vec<f64>,
    /// Loads of the tendons, and which are limited (n).
    guards: Vec<LoadGuard>,
    /// Readings of the last cycle (n).
    samples: Vec<Option<ServoSample>>,
    slow: Vec<Option<SlowSample>>,
    /// Strokes measured last (n) [m].
    measured: Vec<f64>,
    radii: Vec<f64>,
    /// Cycles since each servo answered.
    silent: Vec<u32>,
    n_cycles: u64,
    /// Poses of the last cycle, in the robot's frame if there is a registration.
    poses: Vec<Pose>,
    /// Since when the tip has not moved by a bit.
    still: Option<FrozenPose>,
    /// When the tip was last tracked [s].
    last_tracked: f64,
    events: Vec<Event>,
    stats: RunStats,
    torque: Torque,
    /// Why the torque is not as it shall be, servo by servo, if it is not.
    torque_trouble: Option<String>,
    /// On the way back to rest after a limit was passed: only violations that need torque off at once still count.
    is_going_to_rest: bool,
}

impl std::fmt::Debug for RigSession<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Session").field("rig", &self.rig.name).finish_non_exhaustive()
    }
}

impl<'a> RigSession<'a> {
    /// Switches the torque on at the present position of the robot.
    ///
    /// # Errors
    /// `Bus` if a servo does not answer or does not switch; none is then left under torque.
    pub fn start(
        hardware: &'a mut dyn Hardware,
        rig: &'a RigConfig,
        calibration: &RigCalibration,
        rate: f64,
    ) -> Result<Self> {
        let n = hardware.n_servos();
        let mut samples = vec![None; n];
        hardware.read_servos(&mut samples)?;
        let mut positions = Vec::with_capacity(n);
        for (sample, id) in samples.iter().zip(rig.ids()) {
            let sample = sample.ok_or_else(|| Error::Bus(format!("servo {id} does not answer")))?;
            positions.push(sample.position);
        }
        let mut calibration = calibration.unwrapped(&positions);
        if let Some(TrackerSource::Replay(_)) = rig.tracker.as_ref().map(|tracker| &tracker.source) {
            // What is repeated is in the robot's frame already.
            calibration.registration = Some(Registration::identity());
        }
        let mut strokes = vec![0.0; n];
        calibration.strokes_into(&positions, &mut strokes);
        check_start(rig, &strokes)?;
        let now = hardware.now();
        let mut session = Self {
            radii: rig.tendons.iter().map(|tendon| tendon.pulley_radius).collect(),
            commanded: strokes.clone(),
            target: strokes.clone(),
            guards: vec![LoadGuard::default(); n],
            measured: strokes,
            goals: positions,
            samples,
            slow: vec![None; n],
            silent: vec![0; n],
            n_cycles: 0,
            poses: Vec::with_capacity(16),
            still: None,
            last_tracked: now,
            events: Vec::new(),
            stats: RunStats::new(1.0 / rate),
            is_going_to_rest: false,
            torque_trouble: None,
            torque: Torque::On, // if switching fails half-way, too
            period: 1.0 / rate,
            next: now,
            cycle_time: now,
            calibration,
            hardware,
            rig,
        };
        if let Err(error) = session.switch_on() {
            session.end(TorqueAtEnd::Off);
            return Err(error);
        }
        session.say("torque on");
        session.next = session.hardware.now() + session.period;
        Ok(session)
    }

    fn switch_on(&mut self) -> Result<()> {
        // A servo takes its present position as the goal when its torque goes on; this is for those that do not.
        self.hardware.write_goals(&self.goals)?;
        self.hardware.enable_torque()
    }

    /// Present strokes of the robot (n) [m].
    pub fn strokes(&self) -> &[f64] {
        &self.measured
    }

    /// Readings of the last cycle (n).
    pub fn samples(&self) -> &[Option<ServoSample>] {
        &self.samples
    }

    /// Poses of the last cycle.
    pub fn poses(&self) -> &[Pose] {
        &self.poses
    }

    /// How it has kept its time so far.
    pub fn stats(&self) -> &RunStats {
        &self.stats
    }

    /// Appends what happened since the last call.
    pub fn take_events(&mut self, events: &mut Vec<Event>) {
        events.append(&mut self.events);
    }

    /// Goes to these strokes, no tendon faster than the rig file's slew, and waits there for `settle` [s].
    ///
    /// # Errors
    /// The reason of the stop; the torque is then off.
    pub fn slew(
        &mut self,
        target: &[f64],
        settle: f64,
        stop_requested: &dyn Fn() -> bool,
    ) -> std::result::Result<(), Stop> {
        self.slew_with(target, settle, stop_requested, &mut |_| {})
    }

    /// As [`RigSession::slew`], showing every cycle to `watch`.
    ///
    /// # Errors
    /// The reason of the stop; the torque is then off.
    pub fn slew_with(
        &mut self,
        target: &[f64],
        settle: f64,
        stop_requested: &dyn Fn() -> bool,
        watch: &mut dyn FnMut(&Self),
    ) -> std::result::Result<(), Stop> {
        let done = self.move_to(target, settle, stop_requested, watch);
        if done.is_err() {
            self.end(TorqueAtEnd::Off);
        }
        done
    }

    /// As [`RigSession::slew_with`]; after what does not forbid it, the robot may still go back to rest.
    fn move_to(
        &mut self,
        target: &[f64],
        settle: f64,
        stop_requested: &dyn Fn() -> bool,
        watch: &mut dyn FnMut(&Self),
    ) -> std::result::Result<(), Stop> {
        let start = self.commanded.clone();
        let furthest = start.iter().zip(target).map(|(a, b)| (b - a).abs()).fold(0.0, f64::max);
        let n_moving = (furthest / (self.rig.motion.slew * self.period)).ceil();
        let n_settling = (settle / self.period).ceil();
        let mut strokes = start.clone();
        for i in 1..=(n_moving + n_settling) as u64 {
            if stop_requested() {
                return Err(self.stop_as_requested());
            }
            let part = (i as f64 / n_moving).min(1.0); // 1 also where there is no way to go
            for ((s, a), b) in strokes.iter_mut().zip(&start).zip(target) {
                *s = if part == 1.0 { *b } else { a + part * (b - a) };
            }
            self.cycle(&strokes)?;
            watch(self);
        }
        Ok(())
    }

    /// Brings the robot back to rest, unless what stopped it forbids that, and ends the session: torque as the rig
    /// file says after a run that came to its end, off after any other. What stops it on the way back is the reason
    /// of the end, if there was none before. False if the servos could not be reached.
    fn finish(&mut self, stopped: &mut Option<Stop>, watch: &mut dyn FnMut(&Self)) -> bool {
        if self.torque == Torque::On {
            // On the way back the tip may still be out of sight or bounds: what must not be passed at once is what
            // counts.
            self.is_going_to_rest = true;
            let rest = vec![0.0; self.commanded.len()];
            if let Err(stop) = self.move_to(&rest, SETTLE, &|| false, watch) {
                self.say("the way back to rest was cut short");
                stopped.get_or_insert(stop);
            }
        }
        self.end(if stopped.is_none() { TorqueAtEnd::AsConfigured } else { TorqueAtEnd::Off })
    }

    /// Logs what ended a cycle.
    fn log_stop(&mut self, stop: &Stop) {
        match stop {
            Stop::Limit(violation) => {
                let servo = violation.tendon.map(|k| self.calibration.channels[k].servo_id);
                self.note(EventKind::Limit, servo, violation.message.clone());
            }
            Stop::Failed(error) => self.say(&error.to_string()),
            Stop::Asked => {}
        }
    }

    /// Logs the user's interruption.
    fn stop_as_requested(&mut self) -> Stop {
        self.say("stop requested");
        Stop::Asked
    }

    /// Deals with the torque, once; false if the servos could not be reached.
    fn end(&mut self, end: TorqueAtEnd) -> bool {
        if self.torque != Torque::On {
            return self.torque == Torque::Settled;
        }
        let holds = end == TorqueAtEnd::AsConfigured && self.rig.motion.at_end == AtEnd::Hold;
        let start = self.hardware.now();
        let outcome = loop {
            let done = if holds { self.hardware.hold() } else { self.hardware.disable_torque() };
            self.hardware.take_events(&mut self.events);
            if done.is_ok() || self.hardware.now() - start > RELEASE_PATIENCE {
                break done;
            }
            self.hardware.wait_until(self.hardware.now() + RELEASE_PAUSE);
        };
        self.torque = if outcome.is_ok() { Torque::Settled } else { Torque::Unreachable };
        self.stats.counts = self.hardware.counts();
        match outcome {
            Ok(()) if holds => self.say("torque held"),
            Ok(()) => self.say("torque off"),
            Err(error) => {
                let message =
                    format!("could not switch the torque off: {}; switch the supply off", error.reason());
                self.note(EventKind::BusLost, None, message.clone());
                self.torque_trouble = Some(message);
            }
        }
        for event in &self.events {
            tracing::debug!(time_s = event.time_s, kind = ?event.kind, "{}", event.message);
        }
        self.torque == Torque::Settled
    }

    fn say(&mut self, message: &str) {
        self.note(EventKind::Run, None, message.to_owned());
    }

    fn note(&mut self, kind: EventKind, servo: Option<u8>, message: String) {
        let time_s = self.hardware.now();
        self.events.push(Event { time_s, kind, servo, message });
    }
}

/// Rate of the poses that can be recorded [Hz]; none without a tracker whose frame is known. What is repeated is in the
/// robot's frame already.
fn tip_rate(rig: &RigConfig, calibration: &RigCalibration) -> Option<f64> {
    let is_known = |source: &TrackerSource| {
        calibration.registration.is_some() || matches!(source, TrackerSource::Replay(_))
    };
    rig.tracker.as_ref().filter(|tracker| is_known(&tracker.source)).map(|tracker| tracker.rate)
}

/// Refuses to move a robot whose servos are outside the range of its calibration.
fn check_start(rig: &RigConfig, strokes: &[f64]) -> Result<()> {
    let limits = &rig.limits;
    let far =
        |stroke: f64| stroke < limits.stroke_min - START_MARGIN || stroke > limits.stroke_max + START_MARGIN;
    match strokes.iter().zip(rig.ids()).find(|(stroke, _)| far(**stroke)) {
        None => Ok(()),
        Some((stroke, id)) => Err(Error::Bus(format!(
            "servo {id} is {:.1} mm from its zero, beyond its limits of {:.1} to {:.1} mm (hint: was it turned by \
             hand or exchanged? run `hysteron rig calibrate`)",
            1e3 * stroke,
            1e3 * limits.stroke_min,
            1e3 * limits.stroke_max
        ))),
    }
}

impl Drop for RigSession<'_> {
    fn drop(&mut self) {
        self.end(TorqueAtEnd::Off);
    }
}
