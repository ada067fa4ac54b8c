//! Checks of recordings before anything is fitted to them, learned from them or scored by them.
//!
//! A recording in hand is well formed ([`crate::Recording::new`] sees to that); these checks ask whether it can be true. Each is a
//! pure function of the numbers that costs at most n log n, and each finding carries a number, the limit that it broke and a hint.
//! Suspicious data is a [`Severity::Warning`]; only impossible data is a [`Severity::Error`].

mod channels;
mod copies;
mod delay;
mod excitation;
mod joints;
mod series;
mod tendons;
mod time;

use std::borrow::Cow;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{BadInput, Recording};
use series::MeasuredSeries;

/// Fewest measured rows from which anything is concluded.
const MIN_ROWS: usize = 10;
/// A robot's time constants are shorter [s]: a longer stretch without any change is no motion, and rows further apart are each a rest
/// of its own.
const LONGEST_STILL_S: f64 = 0.5;

/// How sure a finding is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Severity {
    /// It may be right.
    Warning,
    /// It cannot be right.
    Error,
}

/// Kind of finding.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Finding {
    /// Times in another unit than seconds.
    TimeUnit,
    /// Rows that are missing, or were filled in.
    Gap,
    /// Rows at uneven times.
    UnevenTime,
    /// Two rows at almost the same time.
    RepeatedStamp,
    /// Values in another unit than the one in the name.
    Unit,
    /// Speeds that are not the change of the coordinate.
    Speed,
    /// A tip further away than the robot reaches.
    Reach,
    /// A channel that does not change although what drives it does.
    Frozen,
    /// A channel that is measured less often than it is recorded.
    SampleAndHold,
    /// Single rows that repeat the row before.
    DuplicatedRow,
    /// A value that leaves and is back at once.
    Spike,
    /// A jump of a whole turn.
    Wrap,
    /// A channel that stops dead at its largest or smallest value.
    Saturation,
    /// A channel in coarse steps.
    Quantisation,
    /// Numbers that are no orientation.
    Orientation,
    /// A tip that follows its strokes late, or comes before them.
    Delay,
    /// Rows that occur in another recording too.
    CopyOfRecording,
    /// Rows that occur in the same recording twice.
    CopyWithin,
    /// A tendon that is never pulled, or tendons that are always pulled together.
    Tendon,
    /// Too little motion, or too few turns of it, for a fit.
    Excitation,
}

/// A finding with its number.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Warning {
    /// How sure it is.
    pub severity: Severity,
    /// Kind of finding.
    pub kind: Finding,
    /// Name of the recording; empty for a warning about all of them.
    pub recording: String,
    /// Channel, or channels.
    pub channel: String,
    /// First and last row, counted from 1; none for a warning about all rows.
    pub rows: Option<[usize; 2]>,
    /// The finding in words, its number and its limit among them.
    pub finding: String,
    /// The number [`Warning::unit`].
    pub value: f64,
    /// The limit that it broke [`Warning::unit`].
    pub limit: f64,
    /// Unit of both.
    pub unit: Cow<'static, str>,
    /// Advice to the user.
    pub hint: String,
}

impl Warning {
    fn new(kind: Finding, channel: impl Into<String>, finding: impl Into<String>) -> Self {
        Self {
            severity: Severity::Warning,
            kind,
            recording: String::new(),
            channel: channel.into(),
            rows: None,
            finding: finding.into(),
            value: 0.0,
            limit: 0.0,
            unit: Cow::Borrowed("-"),
            hint: String::new(),
        }
    }

    fn measured(mut self, value: f64, limit: f64, unit: &'static str) -> Self {
        (self.value, self.limit, self.unit) = (value, limit, Cow::Borrowed(unit));
        self
    }

    /// Rows from 0.
    fn at_rows(mut self, first: usize, last: usize) -> Self {
        self.rows = Some([first + 1, last + 1]);
        self
    }

    fn hint(mut self, hint: impl Into<String>) -> Self {
        self.hint = hint.into();
        self
    }

    fn impossible(mut self) -> Self {
        self.severity = Severity::Error;
        self
    }

    fn of(mut self, recording: &str) -> Self {
        recording.clone_into(&mut self.recording);
        self
    }

    /// The rows as text: `12` or `12 to 30`; `all` for all rows.
    pub fn rows_text(&self) -> String {
        match self.rows {
            None => "all".to_owned(),
            Some([first, last]) if first == last => first.to_string(),
            Some([first, last]) => format!("{first} to {last}"),
        }
    }

    /// The warning as an error, for callers that refuse it.
    pub fn into_bad_input(self, expected: &str) -> BadInput {
        let place = match self.rows {
            Some(_) => format!("{}, rows {}", self.channel, self.rows_text()),
            None => self.channel.clone(),
        };
        let place = if self.recording.is_empty() { place } else { format!("{}: {place}", self.recording) };
        BadInput::new(place, expected, self.finding).hint(self.hint)
    }
}

impl std::fmt::Display for Warning {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let places = [self.recording.as_str(), self.channel.as_str()];
        let place = places.into_iter().filter(|part| !part.is_empty()).collect::<Vec<_>>().join(": ");
        write!(f, "{place}")?;
        if self.rows.is_some() {
            write!(f, ", rows {}", self.rows_text())?;
        }
        write!(f, ": {}", self.finding)?;
        if !self.hint.is_empty() {
            write!(f, " (hint: {})", self.hint)?;
        }
        Ok(())
    }
}

/// Purpose that recordings are checked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Purpose {
    /// Something is fitted or learned: there must be enough motion.
    Fit,
    /// Something is scored, or only looked at: any motion will do.
    Score,
}

/// Context of the checks: known properties in addition to the recordings.
#[derive(Debug, Clone, Copy)]
pub struct CheckContext<'a> {
    /// Purpose of the recordings.
    pub purpose: Purpose,
    /// Length of the body from its clamp to its tip, where a scene gives it [m].
    pub body_length: Option<f64>,
    /// Range of each joint, where a robot gives it [rad or m].
    pub joint_ranges: &'a [Option<[f64; 2]>],
}

impl CheckContext<'static> {
    /// Nothing is known apart from the recordings.
    pub fn new(purpose: Purpose) -> Self {
        Self { purpose, body_length: None, joint_ranges: &[] }
    }
}

/// Checks one recording; findings about its times come first.
pub fn check_recording(recording: &Recording, context: &CheckContext) -> Vec<Warning> {
    let mut found = one(recording, context);
    found.extend(all(&[("", recording)], context));
    found
}

/// Checks recordings that are used together, each under its name: each alone, then what only all of them show, as copies
/// of each other and tendons that none of them pulls.
pub fn check_recordings(recordings: &[(&str, &Recording)], context: &CheckContext) -> Vec<Warning> {
    let alone = recordings
        .iter()
        .flat_map(|(name, recording)| one(recording, context).into_iter().map(|found| found.of(name)));
    let mut found: Vec<Warning> = alone.collect();
    found.extend(all(recordings, context));
    found
}

/// Looks for numbers of an arm's joints whose unit differs from their names; the first finding.
pub fn check_joint_units(recording: &Recording, joint_ranges: &[Option<[f64; 2]>]) -> Option<Warning> {
    joints::check(recording, joint_ranges).into_iter().next()
}

fn one(recording: &Recording, context: &CheckContext) -> Vec<Warning> {
    let mut found = time::check(recording);
    let measured: Vec<usize> = (0..recording.n_samples()).filter(|&row| !recording.gap()[row]).collect();
    if measured.len() < MIN_ROWS {
        return found;
    }
    let series = MeasuredSeries::of(recording, &measured);
    found.extend(tendons::check(&series, context));
    found.extend(joints::check(recording, context.joint_ranges));
    found.extend(channels::check(&series));
    found.extend(delay::check(&series));
    found
}

fn all(recordings: &[(&str, &Recording)], context: &CheckContext) -> Vec<Warning> {
    let mut found = copies::check(recordings);
    if context.purpose == Purpose::Fit {
        found.extend(excitation::check(recordings));
    }
    found
}

#[cfg(test)]
mod tests;
