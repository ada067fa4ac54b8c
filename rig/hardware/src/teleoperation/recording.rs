//! Recording: every cycle that follows the leader becomes a row, with the channels of the data set NAD.

use super::arms::ArmPair;
use super::config::ArmsConfig;
use super::session::{StopReason, TeleoperationSession};
use crate::bus::model::EffortRegister;
use crate::session::{Histogram, convert, disk, events_path, free_name, journal_path, line_of};
use crate::{Error, Event, EventKind, Result};
use hysteron_base::{JournalQueue, JournalWriter, Metadata};
use std::path::{Path, PathBuf};

/// Recorded quantities of every joint, with their units.
const QUANTITIES: [(&str, &str); 7] = [
    ("q", "rad"),
    ("goal", "rad"),
    ("dq", "rad_s"),
    CURRENT,
    ("voltage", "v"),
    ("temperature", "degc"),
    ("pwm", "ratio"),
];
/// Of servos that do not measure it, the load replaces it.
const CURRENT: (&str, &str) = ("current", "a");

/// Outcome of a recording.
#[derive(Debug)]
pub struct ArmsOutcome {
    /// Where the rows are: under the final name only those of a run that came to its end.
    pub out: PathBuf,
    /// Why it ended before its time, if it did.
    pub stopped: Option<Error>,
    /// Whether the user interrupted it.
    pub was_interrupted: bool,
    /// Rows in the recording, and how many of them were filled in.
    pub n_rows: usize,
    /// See `n_rows`.
    pub n_gaps: usize,
    /// Cycles that began more than a period late.
    pub n_late: usize,
    /// Whether the follower's torque is known to be off.
    pub is_released: bool,
    /// Why not: the state of each servo.
    pub torque_trouble: Option<String>,
    /// From the request for a row's measurements until it was whole, estimates and all.
    pub ages: Histogram,
}

/// Channels of a recording of these arms: those that `hysteron import` makes of NAD.
pub fn channel_names(config: &ArmsConfig) -> Vec<String> {
    let n = config.joints.len();
    let mut names = Vec::with_capacity(7 * n + 2);
    for quantity in QUANTITIES {
        for (k, joint) in (1..).zip(&config.joints) {
            let (stem, unit) = match joint.follower.model.effort {
                EffortRegister::Load if quantity == CURRENT => ("load", "ratio"),
                _ => quantity,
            };
            names.push(format!("{stem}_{k}_{unit}"));
        }
    }
    if config.gripper.is_some() {
        names.extend(["aperture_m", "goal_aperture_m"].map(String::from));
    }
    names
}

/// Takes a row and appends values to it.
pub type Append<'a> = dyn FnMut(&mut Vec<f64>) + 'a;

/// Further channels of a recording, computed from each row as soon as it was measured.
pub struct Estimates<'a> {
    /// Names of the channels.
    pub names: Vec<String>,
    /// Takes a row as it was measured, NaN where a servo did not answer, and appends their values. The next cycle waits for it.
    pub append: Box<Append<'a>>,
}

impl Estimates<'_> {
    /// Nothing is computed.
    pub fn none() -> Self {
        Self { names: Vec::new(), append: Box::new(|_| {}) }
    }
}

impl std::fmt::Debug for Estimates<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Estimates").field("names", &self.names).finish_non_exhaustive()
    }
}

/// A recording that has been begun: its journal is on the disk, and nothing has moved yet. Dropped before its first row it leaves
/// nothing.
#[derive(Debug)]
pub struct ArmsRecording<'a> {
    journal: JournalQueue,
    out: PathBuf,
    estimates: Estimates<'a>,
    ages: Histogram,
    /// Time of the first row [s].
    start: Option<f64>,
    row: Vec<f64>,
    n_late: usize,
    events: Vec<Event>,
}

impl<'a> ArmsRecording<'a> {
    /// Begins the journal: before the torque is switched on, since the disk may stall.
    ///
    /// # Errors
    /// If there is such a journal already or it cannot be written.
    pub fn begin(config: &ArmsConfig, out: &Path, meta: &Metadata, estimates: Estimates<'a>) -> Result<Self> {
        let mut names = channel_names(config);
        names.extend_from_slice(&estimates.names);
        let journal = JournalWriter::create(journal_path(out), &names, meta)?;
        Ok(Self {
            journal: JournalQueue::start(journal).map_err(disk)?,
            out: out.to_owned(),
            estimates,
            ages: Histogram::new(),
            start: None,
            row: Vec::with_capacity(names.len()),
            n_late: 0,
            events: Vec::new(),
        })
    }

    /// Goes to the leader, follows it for `seconds`, or until `stop_requested` where there are none, and returns to rest.
    ///
    /// `progress` receives the time recorded so far [s].
    ///
    /// # Errors
    /// If the follower cannot be put under torque or the recording cannot be written. Whatever ends the run itself is in the
    /// outcome, together with the data.
    pub fn run(
        mut self,
        arms: &mut ArmPair,
        seconds: Option<f64>,
        stop_requested: &dyn Fn() -> bool,
        progress: &mut dyn FnMut(f64),
    ) -> Result<ArmsOutcome> {
        let config = arms.config.clone();
        let mut session = TeleoperationSession::start(arms)?;
        let mut halted = self.follow(&mut session, &config, seconds, stop_requested, progress).err();
        let was_interrupted =
            matches!(halted, Some(StopReason::Asked)) && (seconds.is_some() || self.start.is_none());
        if !matches!(halted, Some(StopReason::Unsafe(_)))
            && let Err(reason) = session.go_to_rest()
        {
            // What went wrong first.
            halted = match halted {
                Some(StopReason::Failed(error)) => Some(StopReason::Failed(error)),
                _ => Some(reason),
            };
        }
        let is_released = session.release();
        let torque_trouble = session.torque_trouble.take();
        self.note(&mut session.events)?;
        drop(session);
        self.journal.flush().map_err(disk)?;
        let stopped = halted.and_then(Option::from);
        let is_whole = stopped.is_none() && !was_interrupted;
        let out = if is_whole { self.out.clone() } else { free_name(&self.out, "partial") };
        let (n_rows, n_gaps) = self.keep(&out)?;
        let ages = std::mem::take(&mut self.ages);
        Ok(ArmsOutcome {
            out,
            stopped,
            was_interrupted,
            n_rows,
            n_gaps,
            n_late: self.n_late,
            is_released,
            torque_trouble,
            ages,
        })
    }

    fn follow(
        &mut self,
        session: &mut TeleoperationSession<'_>,
        config: &ArmsConfig,
        seconds: Option<f64>,
        stop_requested: &dyn Fn() -> bool,
        progress: &mut dyn FnMut(f64),
    ) -> std::result::Result<(), StopReason> {
        session.approach(stop_requested)?;
        session.say("following");
        loop {
            session.follow(config.limits.speed_max)?;
            let passed = self.take(session, config).map_err(StopReason::Failed)?;
            progress(passed);
            if seconds.is_some_and(|seconds| passed >= seconds - 0.5 * config.period) {
                return Ok(());
            }
            if stop_requested() {
                return Err(StopReason::Asked);
            }
        }
    }

    /// Takes the last cycle over; returns its time since the first row [s].
    fn take(&mut self, session: &mut TeleoperationSession<'_>, config: &ArmsConfig) -> Result<f64> {
        let start = *self.start.get_or_insert(session.read_at);
        let time = session.read_at - start;
        let mut add = |value: &dyn Fn(usize) -> Option<f64>| {
            self.row.extend((0..config.joints.len()).map(|k| value(k).unwrap_or(f64::NAN)));
        };
        let samples = &session.samples;
        let mount = |k: usize| &config.joints[k].follower;
        add(&|k| samples[k].map(|sample| mount(k).angle(sample.position)));
        // As the register holds it.
        add(&|k| Some(mount(k).angle(mount(k).ticks(session.goals[k]))));
        let sign = |k: usize| mount(k).turns.sign();
        add(&|k| samples[k].map(|sample| sign(k) * sample.velocity));
        add(&|k| samples[k].map(|sample| sign(k) * sample.effort(mount(k).model)));
        add(&|k| samples[k].map(|sample| sample.voltage));
        add(&|k| samples[k].map(|sample| sample.temperature));
        add(&|k| samples[k].map(|sample| sign(k) * sample.pwm));
        if let Some(gripper) = config.gripper {
            let last = config.joints.len() - 1;
            let [angle, goal] = [self.row[last], self.row[2 * last + 1]];
            self.row.extend([gripper.aperture(angle), gripper.aperture(goal)]);
        }
        (self.estimates.append)(&mut self.row);
        self.ages.add(session.now() - session.read_at);
        let written = self.journal.append(time, &self.row).map_err(disk);
        self.row.clear();
        self.note(&mut session.events)?;
        written.map(|()| time)
    }

    /// Takes events over.
    fn note(&mut self, events: &mut Vec<Event>) -> Result<()> {
        for mut event in events.drain(..) {
            self.n_late += usize::from(event.kind == EventKind::Late);
            // Counted like the rows.
            event.time_s -= self.start.unwrap_or(event.time_s);
            self.journal.note(event.time_s, &line_of(&event)).map_err(disk)?;
            self.events.push(event);
        }
        Ok(())
    }

    /// Turns the journal into the recording and its log; without a single row there is only the log.
    fn keep(&self, out: &Path) -> Result<(usize, usize)> {
        let journal = journal_path(&self.out);
        let counts = if self.start.is_some() {
            convert(&journal, out, ("run.late_cycles", self.n_late.to_string()))?
        } else {
            let lines: String = self.events.iter().map(|event| line_of(event) + "\n").collect();
            hysteron_base::file::write_bytes(&events_path(&self.out), lines)?;
            (0, 0)
        };
        std::fs::remove_file(&journal).map_err(|error| hysteron_base::Error::io(&journal, error))?;
        Ok(counts)
    }
}

impl Drop for ArmsRecording<'_> {
    fn drop(&mut self) {
        if self.start.is_none() {
            // A run that ended has removed it already.
            let _ = std::fs::remove_file(journal_path(&self.out));
        }
    }
}
