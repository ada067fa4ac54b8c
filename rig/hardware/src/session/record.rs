//! Recording: a plan is run, and every cycle becomes a row of a journal as soon as its pose is known.
//!
//! The journal is with the operating system row by row and on the disk every second, so a crash costs at most the
//! rows that still wait for the tracker; no cycle waits for the disk. When the run has ended, however it ended, the
//! journal becomes the recording, under a name of its own where the run did not come to its end: nothing that is cut
//! short ever has the final name.

use super::align::Aligner;
use super::{RigSession, RunStats, SETTLE, Stop, Supervisor, TipFeedback, tip_rate};
use crate::calibration::RigCalibration;
use crate::config::RigConfig;
use crate::{Error, Event, Result};
use hysteron_base::{BadInput, Journal, JournalFile, JournalQueue, JournalWriter, Metadata, Recording, json};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Longest that a row waits for its pose [s].
const WAIT_MAX: f64 = 0.4;
/// Longest message in the log [characters]; escaped, each takes six bytes at most of a journal's 4096.
const LONGEST_MESSAGE: usize = 600;

/// File and metadata of a recording.
#[derive(Debug, Clone)]
pub struct RecordOptions {
    /// The recording, `.parquet` or `.csv`.
    pub out: PathBuf,
    /// Provenance; the run adds how it went.
    pub meta: Metadata,
    /// Channels of the rig's instruments other than servos and tracker, [`Hardware::instruments`](crate::Hardware::instruments).
    pub instruments: Vec<String>,
}

impl RecordOptions {
    /// For a rig without further instruments.
    pub fn new(out: PathBuf, meta: Metadata) -> Self {
        Self { out, meta, instruments: Vec::new() }
    }
}

/// Outcome of a run.
#[derive(Debug)]
pub struct Outcome {
    /// Where the rows are: under the final name only those of a run that came to its end.
    pub out: PathBuf,
    /// How it kept its time.
    pub stats: RunStats,
    /// Events of the run.
    pub events: Vec<Event>,
    /// Why it ended before the plan and the way back to rest did, if it did.
    pub stopped: Option<Stop>,
    /// Rows in the recording, and how many of them were filled in; without a single row there is none, only its log.
    pub n_rows: usize,
    /// See `n_rows`.
    pub n_gaps: usize,
    /// Whether the torque is as it shall be; if not, the servos could not be reached for [`RigSession`]'s patience.
    pub is_torque_settled: bool,
    /// Why not: the state of each servo.
    pub torque_trouble: Option<String>,
}

/// Channels of a recording of this rig.
fn names_of(rig: &RigConfig, calibration: &RigCalibration, options: &RecordOptions) -> Vec<String> {
    channel_names(rig.tendons.len(), &options.instruments, tip_rate(rig, calibration).is_some())
}

/// The journal of a recording that is under way.
pub fn journal_path(out: &Path) -> PathBuf {
    out.with_extension("journal")
}

/// Channels of a recording with `n` tendons and further instruments, with or without a tracked tip.
fn channel_names(n: usize, instruments: &[String], with_tip: bool) -> Vec<String> {
    let numbered = |stem: &str, unit: &str| (1..=n).map(|k| format!("{stem}_{k}{unit}")).collect::<Vec<_>>();
    let mut names = numbered("stroke", "_m");
    names.extend(numbered("tick_goal", ""));
    names.extend(numbered("tick_present", ""));
    names.extend(numbered("load", ""));
    names.extend_from_slice(instruments);
    if with_tip {
        names.extend(
            ["tip_x_m", "tip_y_m", "tip_z_m", "tip_qw", "tip_qx", "tip_qy", "tip_qz"].map(String::from),
        );
    }
    names
}

/// A recording that has been begun: its journal is on the disk, and nothing has moved yet. Dropped before its first row
/// it leaves nothing.
#[derive(Debug)]
pub struct RigRecorder {
    tape: JournalTape,
    feedback: Option<TipFeedback>,
    options: RecordOptions,
    channels: Vec<String>,
}

impl RigRecorder {
    /// Begins the journal: before the torque is switched on, since the disk may stall.
    ///
    /// # Errors
    /// If there is such a journal already or it cannot be written.
    pub fn begin(rig: &RigConfig, calibration: &RigCalibration, options: RecordOptions) -> Result<Self> {
        let names = names_of(rig, calibration, &options);
        let journal = JournalWriter::create(journal_path(&options.out), &names, &options.meta)?;
        Self::of(journal, rig, calibration, options)
    }

    /// The same in a file of another kind, which has the journal's name.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn begin_in(
        file: Arc<dyn JournalFile>,
        rig: &RigConfig,
        calibration: &RigCalibration,
        options: RecordOptions,
    ) -> Result<Self> {
        let names = names_of(rig, calibration, &options);
        let journal = JournalWriter::over(file, &names, &options.meta).map_err(disk)?;
        Self::of(journal, rig, calibration, options)
    }

    fn of(
        journal: JournalWriter,
        rig: &RigConfig,
        calibration: &RigCalibration,
        options: RecordOptions,
    ) -> Result<Self> {
        let (n, rate) = (rig.tendons.len(), tip_rate(rig, calibration));
        let channels = names_of(rig, calibration, &options);
        let tape = JournalTape {
            journal: JournalQueue::start(journal).map_err(disk)?,
            aligner: Aligner::new(4 * n + options.instruments.len(), rate, WAIT_MAX),
            n_written: channels.len(),
            instruments: Vec::with_capacity(options.instruments.len()),
            n_instruments: options.instruments.len(),
            start: 0.0,
            last: None,
            commanded: Vec::with_capacity(2 * n),
            is_real_time: true,
            events: Vec::new(),
            supervisor: None,
        };
        Ok(Self { tape, feedback: None, options, channels })
    }

    /// Channels of the recording, in the order of its rows.
    pub fn channels(&self) -> &[String] {
        &self.channels
    }

    /// Lets `supervisor` follow the recording; it may end it.
    #[must_use]
    pub fn supervised_by(mut self, supervisor: Box<dyn Supervisor>) -> Self {
        self.tape.supervisor = Some(supervisor);
        self
    }

    /// Corrects the strokes by the tip that is measured while they are run.
    #[must_use]
    pub fn with_feedback(mut self, feedback: TipFeedback) -> Self {
        self.feedback = Some(feedback);
        self
    }

    /// Goes to rest, follows the strokes of `commands` (n tendons) sample by sample, returns to rest and ends the
    /// session.
    ///
    /// `progress` receives the number of rows done; `stop_requested` returns whether the recording should stop.
    ///
    /// # Errors
    /// If the recording cannot be written. What ends the run itself is in the outcome, together with the data.
    pub fn run(
        mut self,
        // Dropped before the tape, which may have to wait for the disk.
        mut session: RigSession<'_>,
        commands: &Recording,
        stop_requested: &dyn Fn() -> bool,
        progress: &mut dyn FnMut(usize),
    ) -> Result<Outcome> {
        let strokes = commands.strokes();
        let n = session.commanded.len();
        if strokes.len() != n {
            let expected = format!("{n} strokes, one per tendon of the rig");
            return Err(BadInput::new("plan", expected, format!("{} strokes", strokes.len())).into());
        }
        let tape = &mut self.tape;
        tape.is_real_time = session.hardware.is_real_time();
        let clocks = |session: &RigSession<'_>| (session.hardware.now(), session.hardware.processor_time());
        let before = clocks(&session);
        let feedback = self.feedback.as_mut();
        let mut stopped = follow(&mut session, (&strokes, feedback), tape, stop_requested, progress).err();
        if let ((start, Some(used_before)), (end, Some(used))) = (before, clocks(&session)) {
            session.stats.processor = Some((used - used_before) / (end - start));
        }
        // The last rows wait for the poses after them.
        let mut watch = |session: &RigSession<'_>| tape.aligner.push_poses(&session.poses);
        let is_torque_settled = session.finish(&mut stopped, &mut watch);
        let last_events = std::mem::take(&mut session.events);
        let torque_trouble = session.torque_trouble.take();
        let mut stats = session.stats.clone();
        stats.heat.begin_at(tape.start);
        drop(session);
        if let Err(error) = tape.finish(last_events) {
            stopped.get_or_insert(Stop::Failed(error));
        }
        let out = if stopped.is_none() {
            self.options.out.clone()
        } else {
            free_name(&self.options.out, "partial")
        };
        match self.keep(&out, &stats) {
            Ok((n_rows, n_gaps)) => {
                let events = std::mem::take(&mut self.tape.events);
                Ok(Outcome { out, stats, events, stopped, n_rows, n_gaps, is_torque_settled, torque_trouble })
            }
            // What went wrong first.
            Err(error) => match stopped {
                Some(Stop::Failed(first)) => Err(first),
                _ => Err(error),
            },
        }
    }

    /// Turns the journal of a run that has ended into its recording and its log of events; the journal is removed when
    /// both are whole. A run without a single row leaves its log alone. Returns the rows, and how many were filled in.
    fn keep(&self, out: &Path, stats: &RunStats) -> Result<(usize, usize)> {
        let journal = journal_path(&self.options.out);
        let counts = if self.tape.last.is_some() {
            let summary = json::to_line(stats.summary()).unwrap_or_default();
            convert(&journal, out, ("run.stats", summary))?
        } else {
            let lines: String = self.tape.events.iter().map(|event| line_of(event) + "\n").collect();
            hysteron_base::file::write_bytes(&events_path(&self.options.out), lines)?;
            (0, 0)
        };
        std::fs::remove_file(&journal).map_err(|e| hysteron_base::Error::io(&journal, e))?;
        Ok(counts)
    }
}

impl Drop for RigRecorder {
    fn drop(&mut self) {
        if self.tape.last.is_none() {
            // A run that ended has removed it already.
            let _ = std::fs::remove_file(journal_path(&self.options.out));
        }
    }
}

/// `NAME.kind-1.parquet`, or with the first number that is free.
pub fn free_name(out: &Path, kind: &str) -> PathBuf {
    let ending = out.extension().unwrap_or_default().to_string_lossy();
    let named = |number: u32| out.with_extension(format!("{kind}-{number}.{ending}"));
    (1..).map(named).find(|path| !path.exists()).unwrap_or_default()
}

/// Goes to the first sample and follows them all, corrected by the tip where there is feedback.
fn follow(
    session: &mut RigSession<'_>,
    (strokes, mut feedback): (&[&[f64]], Option<&mut TipFeedback>),
    tape: &mut JournalTape,
    stop_requested: &dyn Fn() -> bool,
    progress: &mut dyn FnMut(usize),
) -> std::result::Result<(), Stop> {
    let sample = |i: usize| strokes.iter().map(move |channel| channel[i]);
    let mut target: Vec<f64> = sample(0).collect();
    // The first row needs the pose before it.
    session
        .move_to(&target, SETTLE, stop_requested, &mut |session| tape.aligner.push_poses(&session.poses))?;
    session.say("recording");
    for i in 0..strokes[0].len() {
        if stop_requested() {
            return Err(session.stop_as_requested());
        }
        target.iter_mut().zip(sample(i)).for_each(|(s, commanded)| *s = commanded);
        if let Some(feedback) = &mut feedback {
            let start = tape.start;
            session.poses.iter().for_each(|pose| feedback.take_pose(pose, pose.time - start));
            feedback.correct(i, &session.commanded, &mut target);
        }
        let n_before = session.n_cycles;
        let done = session.cycle(&target);
        // What was measured is kept even if it is what ends the run; what was not is no row.
        if session.n_cycles > n_before
            && let Err(error) = tape.take(session)
        {
            session.say(&error.to_string());
            return Err(error.into());
        }
        done?;
        tape.ask_supervisor(session)?;
        progress(i + 1);
    }
    session.say("the plan is done");
    Ok(())
}

/// The journal and what is on its way to it.
#[derive(Debug)]
struct JournalTape {
    journal: JournalQueue,
    aligner: Aligner,
    /// Channels of the journal; without a tracker the pose at a row's end is cut off.
    n_written: usize,
    /// Time of the first row on the rig's clock [s].
    start: f64,
    /// Time of the last row on the rig's clock [s], once there is one.
    last: Option<f64>,
    /// Strokes and goals commanded in it.
    commanded: Vec<f64>,
    /// Readings of the instruments in it, and their number.
    instruments: Vec<f64>,
    n_instruments: usize,
    /// Whether the cycle must not wait for the disk.
    is_real_time: bool,
    /// Events passed to the journal so far.
    events: Vec<Event>,
    /// Who follows the rows.
    supervisor: Option<Box<dyn Supervisor>>,
}

impl JournalTape {
    /// Takes the last cycle over.
    fn take(&mut self, session: &mut RigSession<'_>) -> Result<()> {
        let time = session.cycle_time;
        if self.last.is_none() {
            self.start = time;
        }
        self.fill_missed(time, session.period);
        let channels = &session.calibration.channels;
        self.commanded.clear();
        self.commanded
            .extend(session.goals.iter().zip(channels).map(|(goal, channel)| channel.stroke(*goal)));
        self.commanded.extend(session.goals.iter().map(|goal| f64::from(*goal)));
        let samples = &session.samples;
        let present = samples.iter().map(|s| s.map_or(f64::NAN, |s| f64::from(s.position)));
        let loads = samples.iter().map(|s| s.map_or(f64::NAN, |s| s.load));
        self.instruments.clear();
        session.hardware.read_instruments(&mut self.instruments);
        let instruments = self.instruments.iter().copied();
        self.aligner
            .push_row(time, self.commanded.iter().copied().chain(present).chain(loads).chain(instruments));
        self.aligner.push_poses(&session.poses);
        self.note(&mut session.events)?;
        self.write(session.hardware.now())
    }

    /// Rows for cycles that came too late to take place before `time` [s]: the command held, nothing measured.
    fn fill_missed(&mut self, time: f64, period: f64) {
        let Some(last) = self.last.replace(time) else { return };
        let n_missed = ((time - last) / period).round() as u64;
        for i in 1..n_missed {
            let nothing = std::iter::repeat_n(f64::NAN, self.commanded.len() + self.n_instruments);
            self.aligner.push_row(last + i as f64 * period, self.commanded.iter().copied().chain(nothing));
        }
    }

    /// Writes the rows that are ready.
    fn write(&mut self, now: f64) -> Result<()> {
        if !self.is_real_time {
            self.journal.wait_for_room();
        }
        while let Some((time, row)) = self.aligner.pop(now) {
            let (time, row) = (time - self.start, &row[..self.n_written]);
            self.journal.append(time, row).map_err(disk)?;
            if let Some(supervisor) = &mut self.supervisor {
                supervisor.take_row(time, row);
            }
        }
        Ok(())
    }

    /// Asks who follows the rows what he found.
    fn ask_supervisor(&mut self, session: &mut RigSession<'_>) -> std::result::Result<(), Stop> {
        let Some(supervisor) = &mut self.supervisor else { return Ok(()) };
        let mut notes = Vec::new();
        let checked = supervisor.check(&mut notes);
        notes.into_iter().for_each(|(kind, message)| session.note(kind, None, message));
        checked.map_err(|violation| session.stopped(violation.into()))
    }

    /// Takes events over.
    fn note(&mut self, events: &mut Vec<Event>) -> Result<()> {
        let first = self.events.len();
        self.events.append(events);
        for event in &self.events[first..] {
            // Counted like the rows.
            let event = Event { time_s: event.time_s - self.start, ..event.clone() };
            self.journal.note(event.time_s, &line_of(&event)).map_err(disk)?;
        }
        Ok(())
    }

    /// Writes what still waits.
    fn finish(&mut self, mut events: Vec<Event>) -> Result<()> {
        // The servos are dealt with: there is time.
        self.is_real_time = false;
        let rows = self.write(f64::INFINITY);
        let notes = self.note(&mut events);
        let flushed = self.journal.flush().map_err(disk);
        rows.and(notes).and(flushed)
    }
}

/// An event as a line of the log. A message can quote received data: it is cut to the limit of a journal.
pub(crate) fn line_of(event: &Event) -> String {
    let message = event.message.chars().take(LONGEST_MESSAGE).collect();
    // Numbers and text, which JSON holds.
    json::to_line(&Event { message, ..event.clone() }).unwrap_or_default()
}

/// A refusal of the file system, for people.
pub(crate) fn disk(error: std::io::Error) -> Error {
    Error::Disk(error)
}

/// Turns a journal that a crash has left into a recording and its log; the journal stays.
///
/// # Errors
/// If the journal holds no row, or a file cannot be written.
pub fn recover(journal: &Path, out: &Path) -> Result<(usize, usize)> {
    convert(journal, out, ("run.recovered", "true".to_owned()))
}

/// The recording and the log of a journal, with one more pair of metadata.
pub(crate) fn convert(journal: &Path, out: &Path, (key, value): (&str, String)) -> Result<(usize, usize)> {
    let Journal { recording, notes, .. } = Journal::read(journal)?;
    let mut meta = recording.meta().clone();
    meta.extra.insert(key.to_owned(), value);
    let recording = Recording::new(
        recording.time().to_vec(),
        recording.channels().to_vec(),
        recording.gap().to_vec(),
        meta,
    )?;
    recording.write(out)?;
    let mut lines = String::new();
    for (_, note) in &notes {
        lines.push_str(note);
        lines.push('\n');
    }
    hysteron_base::file::write_bytes(&events_path(out), lines)?;
    let n_gaps = recording.gap().iter().filter(|gap| **gap).count();
    Ok((recording.n_samples(), n_gaps))
}

/// The log of events next to a recording: one JSON object a line.
pub fn events_path(out: &Path) -> PathBuf {
    out.with_extension("events.jsonl")
}
