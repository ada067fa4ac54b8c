//! Estimates of one window of recordings.

use std::collections::BTreeSet;
use std::f64::consts::TAU;

use hysteron_base::{BadInput, Recording, json};
use serde::Deserialize;

use super::{Estimate, Numbers, Quantity};
use crate::identify::{
    PulleyRecord, SlackFriction, SteadySamples, finest_speed, lost_motion, slack_friction,
};
use crate::servo::{TICKS_PER_TURN, stroke_per_tick};

/// Length of a window in recorded time [s].
const LENGTH: f64 = 60.0;
/// The last window may be as short as this part of it.
const SHORTEST: f64 = 0.25;
/// Fewest families of shapes from which lost motion is estimated: going round one shape, a tip that lags and one that bends look alike.
const FAMILIES: usize = 3;
/// Slowest steady motion at any rate [rad/s].
const SLOWEST: f64 = 0.03;

/// A part of a recording.
#[derive(Debug, Clone, Copy)]
struct RecordingPart<'a> {
    recording: &'a Recording,
    from: usize,
    until: usize,
}

/// Recordings of one rig.
pub(super) struct ServoRecordings<'a> {
    recordings: Vec<&'a Recording>,
    /// Stroke of a tick of every servo [m].
    per_tick: Vec<Option<f64>>,
    period: f64,
}

/// Results of one window.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Window {
    /// Recorded time, one recording after the other [s].
    pub from: f64,
    pub until: f64,
    /// Servo by servo.
    pub servos: Vec<Numbers>,
    /// Highest temperatures (n) [°C]; empty where none were read.
    pub hottest: Vec<f64>,
}

impl<'a> ServoRecordings<'a> {
    /// `None` where there is nothing of servos.
    pub fn new(recordings: &[&'a Recording]) -> Result<Option<Self>, BadInput> {
        let Some(first) = recordings.first() else { return Ok(None) };
        let n = first.numbered("tick_present", "").len();
        let counts = |recording: &Recording| {
            [("tick_present", ""), ("tick_goal", ""), ("load", ""), ("stroke", "m")]
                .map(|(stem, unit)| recording.numbered(stem, unit).len())
        };
        if n == 0 || recordings.iter().any(|recording| counts(recording) != [n; 4]) {
            return Ok(None);
        }
        let Some(rate) = first.rate_hz() else { return Ok(None) };
        let slope = |k: usize| {
            recordings.iter().find_map(|recording| {
                stroke_per_tick(recording.numbered("tick_goal", "")[k], recording.strokes()[k])
            })
        };
        Ok(Some(Self {
            per_tick: (0..n).map(slope).collect(),
            recordings: recordings.to_vec(),
            period: 1.0 / rate,
        }))
    }

    pub fn n_servos(&self) -> usize {
        self.per_tick.len()
    }

    /// All windows.
    pub fn windows(&self) -> Vec<Window> {
        let length = (LENGTH / self.period).round().max(1.0) as usize;
        let (mut windows, mut parts): (Vec<Window>, Vec<RecordingPart<'a>>) = (Vec::new(), Vec::new());
        let (mut rows, mut done) = (0, 0);
        for recording in &self.recordings {
            let mut from = 0;
            while from < recording.n_samples() {
                let until = recording.n_samples().min(from + length - rows);
                parts.push(RecordingPart { recording, from, until });
                rows += until - from;
                from = until;
                if rows == length {
                    windows.push(self.window(&parts, done));
                    (done, rows) = (done + rows, 0);
                    parts.clear();
                }
            }
        }
        if rows as f64 >= SHORTEST * length as f64 || windows.is_empty() && rows > 0 {
            windows.push(self.window(&parts, done));
        }
        windows
    }

    fn window(&self, parts: &[RecordingPart<'a>], done: usize) -> Window {
        let n = self.n_servos();
        let rows: usize = parts.iter().map(|part| part.until - part.from).sum();
        let mut servos = vec![Numbers::default(); n];
        for (k, numbers) in servos.iter_mut().enumerate() {
            if let Some(SlackFriction { dry, standard_error, .. }) = self.friction(parts, k) {
                for (j, quantity) in [Quantity::Pulling, Quantity::Releasing].into_iter().enumerate() {
                    let [value, standard_error] = [dry[j], standard_error[j]].map(|part| 100.0 * part);
                    numbers.set(quantity, Some(Estimate { value, standard_error }));
                }
            }
        }
        for (numbers, lost) in servos.iter_mut().zip(self.lost_motion(parts).into_iter().flatten()) {
            numbers.set(Quantity::LostMotion, Some(lost));
        }
        let heat: Vec<Vec<f64>> = parts.iter().flat_map(temperatures).collect();
        for (k, numbers) in servos.iter_mut().enumerate().filter(|_| !heat.is_empty()) {
            let mean = heat.iter().map(|row| row[k]).sum::<f64>() / heat.len() as f64;
            numbers.temperature_degc = Some(mean);
        }
        let hottest = |k: usize| heat.iter().map(|row| row[k]).reduce(f64::max);
        Window {
            from: self.period * done as f64,
            until: self.period * (done + rows) as f64,
            servos,
            hottest: (0..n).filter_map(hottest).collect(),
        }
    }

    /// `None` where the motion does not determine it.
    fn friction(&self, parts: &[RecordingPart], k: usize) -> Option<SlackFriction> {
        let sign = self.per_tick[k]?.signum();
        let series = |stem: &str, factor: f64| -> Vec<Vec<f64>> {
            let of =
                |part: &RecordingPart| part.recording.numbered(stem, "")[k][part.from..part.until].to_vec();
            let scaled = |values: Vec<f64>| values.into_iter().map(|x| factor * x).collect();
            parts.iter().map(of).map(scaled).collect()
        };
        let (angles, loads) = (series("tick_present", sign * TAU / TICKS_PER_TURN), series("load", sign));
        let records: Vec<PulleyRecord> = angles
            .iter()
            .zip(&loads)
            .map(|(angle, load)| PulleyRecord { angle, load, tension: None })
            .collect();
        let samples =
            SteadySamples::of(&records, self.period, finest_speed(self.period).max(SLOWEST)).ok()?;
        slack_friction(&samples).ok()
    }

    /// Lost motion of every servo [mm]; `None` without a tip, for too few shapes, or where a servo rested.
    fn lost_motion(&self, parts: &[RecordingPart<'a>]) -> Option<Vec<Estimate>> {
        let family = |part: &RecordingPart<'a>| part.recording.meta().extra.get("plan.family");
        if parts.iter().filter_map(family).collect::<BTreeSet<_>>().len() < FAMILIES {
            return None;
        }
        let per_tick = self.per_tick.iter().copied().collect::<Option<Vec<f64>>>()?;
        let mut travel = vec![Vec::new(); per_tick.len()];
        let mut tip = vec![Vec::new(); 3];
        for part in parts {
            let present = part.recording.numbered("tick_present", "");
            for (k, series) in travel.iter_mut().enumerate() {
                series.extend(present[k][part.from..part.until].iter().map(|ticks| ticks * per_tick[k]));
            }
            for (series, values) in tip.iter_mut().zip(part.recording.tip()?) {
                series.extend_from_slice(&values[part.from..part.until]);
            }
        }
        let found = lost_motion(&travel, &tip).ok()?;
        let both = found.width.iter().zip(&found.standard_error);
        Some(both.map(|(w, e)| Estimate { value: 1e3 * w, standard_error: 1e3 * e }).collect())
    }
}

/// Temperatures in a recording's metadata [°C].
#[derive(Deserialize)]
struct Stats {
    #[serde(default)]
    temperature_degc: Vec<Vec<f64>>,
}

/// Temperatures of all servos that were read within a part of a recording.
fn temperatures(part: &RecordingPart) -> Vec<Vec<f64>> {
    let n = part.recording.numbered("tick_present", "").len();
    let text = part.recording.meta().extra.get("run.stats");
    let stats: Option<Stats> = text.and_then(|text| json::from_text(text).ok());
    let time = part.recording.time();
    let within =
        |t: f64| t >= time[part.from] && part.until.checked_sub(1).is_some_and(|last| t <= time[last]);
    let rows = stats.map_or_else(Vec::new, |stats| stats.temperature_degc);
    rows.into_iter().filter(|row| row.len() == n + 1 && within(row[0])).map(|row| row[1..].to_vec()).collect()
}
