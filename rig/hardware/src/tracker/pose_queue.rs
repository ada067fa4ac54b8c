//! Processing of messages: poses of the one selected tool are put on the host's clock and evaluated; the rest
//! is counted and reported as events.

use super::clock::ClockMap;
use super::decoder::DecodedMessage;
use super::message::{Message, MessageContent, ToolPose, Validity};
use super::quality::{Monitor, PoseLimits};
use super::repeats::RepeatWatch;
use crate::{Event, EventKind, Pose, Quality};
use std::collections::VecDeque;

/// Most poses and events that wait to be taken; beyond, the oldest are lost and counted.
const MAX_QUEUED: usize = 16 * 1024;
/// Most names of other tools that are remembered.
const MAX_NAMES: usize = 16;
/// Longest that a repeated pose is withheld, and the part of the time without poses that is no fault yet [s, -].
const HOLD: (f64, f64) = (0.15, 0.5);
/// Shortest time between two events of a kind that can come with every message [s].
const REST: f64 = 1.0;

/// How many of everything came from the tracker.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct PoseCounts {
    /// Poses handed on, good or not.
    pub poses: u64,
    /// Of these, poses that are not good.
    pub doubtful: u64,
    /// Damages of the stream, and damaged messages.
    pub damaged: u64,
    /// Messages of other types or tools.
    pub skipped: u64,
    /// Poses left out since their time stamp fits no clock.
    pub unplaced: u64,
    /// Poses left out since they are no later than the one before: repetitions, and those that a better estimate of
    /// the tracker's clock puts there.
    pub repeated: u64,
    /// Poses that were not read and are lost.
    pub overflowed: u64,
}

/// Collects what the tracker sends.
#[derive(Debug)]
pub(super) struct PoseQueue {
    /// The tool that matters; the first that comes if none was named.
    device: Option<String>,
    clock: ClockMap,
    monitor: Monitor,
    repeats: RepeatWatch,
    /// Poses on their way from there.
    decided: Vec<Pose>,
    stale_after: f64,
    last_stamp: Option<f64>,
    last_time: f64,
    last_quality: Quality,
    /// Why the last pose that was flagged was.
    flaw: Validity,
    /// When a pose last arrived, or the connection was made [s].
    last_arrival: f64,
    stale: bool,
    others: Vec<String>,
    damage: Burst,
    status: Burst,
    pub poses: VecDeque<Pose>,
    pub events: VecDeque<Event>,
    pub counts: PoseCounts,
}

/// An event that can come with every message, logged at most once per [`REST`].
#[derive(Debug, Default)]
struct Burst {
    last: Option<f64>,
    n_withheld: usize,
    what: String,
}

impl Burst {
    /// One more at `now` [s]; returns the message to log, if it is time.
    fn note(&mut self, now: f64, what: String) -> Option<String> {
        self.n_withheld += 1;
        self.what = what;
        self.flush(now)
    }

    /// Report of the events withheld, if it is due.
    fn flush(&mut self, now: f64) -> Option<String> {
        if self.n_withheld == 0 || self.last.is_some_and(|last| now - last < REST) {
            return None;
        }
        self.last = Some(now);
        let n = std::mem::take(&mut self.n_withheld);
        let what = std::mem::take(&mut self.what);
        Some(if n == 1 { what } else { format!("{what}; {n} such since the last report") })
    }
}

impl PoseQueue {
    pub fn new(device: Option<String>, latency: f64, stale_after: f64, limits: PoseLimits) -> Self {
        Self {
            device,
            clock: ClockMap::new(latency),
            monitor: Monitor::new(limits),
            repeats: RepeatWatch::new(HOLD.0.min(HOLD.1 * stale_after)),
            decided: Vec::new(),
            stale_after,
            last_stamp: None,
            last_time: f64::NEG_INFINITY,
            last_quality: Quality::Good,
            flaw: Validity::Marked,
            last_arrival: 0.0,
            stale: false,
            others: Vec::new(),
            damage: Burst::default(),
            status: Burst::default(),
            poses: VecDeque::new(),
            events: VecDeque::new(),
            counts: PoseCounts::default(),
        }
    }

    /// The connection was made at `now` [s].
    pub fn connected(&mut self, now: f64) {
        (self.last_arrival, self.stale) = (now, false);
    }

    /// Time passes, with or without messages; `now` [s].
    pub fn tick(&mut self, now: f64) {
        if let Some(message) = self.damage.flush(now) {
            self.log(now, EventKind::TrackerCorrupt, message);
        }
        if let Some(message) = self.status.flush(now) {
            self.log(now, EventKind::TrackerQuality, message);
        }
        if !self.stale && now - self.last_arrival > self.stale_after {
            self.stale = true;
            let silence = (now - self.last_arrival) * 1e3;
            let mut message = format!("no new pose of {} for {silence:.0} ms", self.device_name());
            if !self.others.is_empty() {
                message.push_str(&format!("; the tracker also sends {}", self.others.join(", ")));
            }
            self.log(now, EventKind::TrackerStale, message);
        }
    }

    /// Takes what arrived at `arrival` [s].
    pub fn take(&mut self, decoded: DecodedMessage, arrival: f64) {
        match decoded {
            DecodedMessage::Message(message) => self.message(message, arrival),
            DecodedMessage::Skipped { .. } => self.counts.skipped += 1,
            DecodedMessage::Damaged(what) => {
                self.counts.damaged += 1;
                if let Some(message) = self.damage.note(arrival, what) {
                    self.log(arrival, EventKind::TrackerCorrupt, message);
                }
            }
        }
    }

    fn message(&mut self, message: Message, arrival: f64) {
        let Message { device, time, content } = message;
        match content {
            MessageContent::Transform(pose) | MessageContent::Position(pose) => {
                self.tool(&device, &pose, time, arrival)
            }
            MessageContent::Tools(tools) => {
                tools.iter().for_each(|(name, pose)| self.tool(name, pose, time, arrival));
            }
            MessageContent::Status { code: 1, .. } => {}
            MessageContent::Status { code, text } => {
                if let Some(message) = self.status.note(arrival, format!("{device}: status {code} {text}")) {
                    self.log(arrival, EventKind::TrackerQuality, message);
                }
            }
        }
    }

    fn tool(&mut self, name: &str, pose: &ToolPose, stamp: Option<f64>, arrival: f64) {
        if *self.device.get_or_insert_with(|| name.to_owned()) != name {
            self.counts.skipped += 1;
            if self.others.len() < MAX_NAMES && !self.others.iter().any(|other| other == name) {
                self.others.push(name.to_owned());
            }
            return;
        }
        if stamp.is_some() && stamp == self.last_stamp {
            self.counts.repeated += 1;
            return;
        }
        self.last_stamp = stamp;
        let time = match stamp {
            Some(stamp) => self.clock.map(stamp, arrival),
            None => Some(self.clock.without_stamp(arrival)),
        };
        let Some(time) = time else {
            self.counts.unplaced += 1;
            let what = format!("the time stamp of {name} does not fit those before; its pose was discarded");
            if let Some(message) = self.status.note(arrival, what) {
                self.log(arrival, EventKind::TrackerQuality, message);
            }
            return;
        };
        if time <= self.last_time {
            self.counts.repeated += 1;
            return;
        }
        (self.last_time, self.last_arrival, self.stale) = (time, arrival, false);
        let quality = if pose.is_valid() { Quality::Good } else { Quality::Flagged };
        // A pose that is valid and flagged all the same is out of the tracker's range.
        self.flaw = if pose.is_valid() { Validity::Marked } else { pose.validity };
        let mut pose = Pose { time, position: pose.position, orientation: pose.orientation, quality };
        pose.quality = self.monitor.evaluate(&pose);
        let mut decided = std::mem::take(&mut self.decided);
        self.repeats.take(pose, &mut decided);
        for pose in decided.drain(..) {
            self.hand_on(name, pose, arrival);
        }
        self.decided = decided;
    }

    fn hand_on(&mut self, name: &str, pose: Pose, arrival: f64) {
        self.counts.poses += 1;
        if pose.quality != Quality::Good {
            self.counts.doubtful += 1;
            if pose.quality != self.last_quality {
                let [x, y, z] = pose.position.map(|x| x * 1e3);
                let what = format!("{name} is {} at {x:.1} {y:.1} {z:.1} mm", words(pose.quality, self.flaw));
                if let Some(message) = self.status.note(arrival, what) {
                    self.log(arrival, EventKind::TrackerQuality, message);
                }
            }
        }
        self.last_quality = pose.quality;
        if self.poses.len() >= MAX_QUEUED {
            self.poses.pop_front();
            self.counts.overflowed += 1;
        }
        self.poses.push_back(pose);
    }

    /// The tool that matters, for a person.
    pub fn device_name(&self) -> &str {
        self.device.as_deref().unwrap_or("any tool")
    }

    /// Adds an event at `now` [s].
    pub fn log(&mut self, now: f64, kind: EventKind, message: String) {
        if self.events.len() >= MAX_QUEUED {
            self.events.pop_front();
        }
        self.events.push_back(Event { time_s: now, kind, servo: None, message });
    }
}

/// A quality, for a person.
fn words(quality: Quality, flaw: Validity) -> &'static str {
    match quality {
        Quality::Good => "good",
        Quality::Flagged => flaw.words(),
        Quality::Frozen => "frozen: the same values again and again",
        Quality::Jump => "further away than the tip can have moved",
    }
}

#[cfg(test)]
mod tests;
