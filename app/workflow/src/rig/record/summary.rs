//! Summary of a recording session, for the terminal, the report and `metrics.json`.

use std::path::{Path, PathBuf};

use hysteron_base::{Metadata, Recording, json};
use hysteron_rig::session::{Outcome, StatsSummary, events_path};
use hysteron_rig::{Event, EventKind};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::jobs::Job;
use crate::Context;

/// One trajectory.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct RecordedTrajectory {
    /// Name of the trajectory.
    pub name: String,
    /// Role of the recording: training, validation or test.
    pub role: String,
    /// Number of samples.
    pub rows: usize,
    /// Samples that were not measured and are filled in.
    pub filled_in: usize,
    /// Events beyond the course of the run.
    pub events: usize,
    /// Timing of the cycles, on a rig.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub timing: Option<StatsSummary>,
    #[serde(skip)]
    out: PathBuf,
    #[serde(skip)]
    order: usize,
}

impl RecordedTrajectory {
    /// Headings of [`RecordedTrajectory::cells`].
    pub const HEADINGS: [&'static str; 7] = [
        "Trajectory",
        "Role",
        "Samples",
        "Filled in",
        "Events",
        "Late, 99 % [ms]",
        "Bus, median (wire) [ms]",
    ];

    /// The row for people.
    pub fn cells(&self) -> Vec<String> {
        let timing = self.timing.as_ref();
        vec![
            self.name.clone(),
            self.role.clone(),
            self.rows.to_string(),
            self.filled_in.to_string(),
            self.events.to_string(),
            timing.map_or("-".to_owned(), |t| format!("{:.3}", t.late_p99_ms)),
            timing.map_or("-".to_owned(), |t| format!("{:.2} ({:.2})", t.bus_median_ms, t.wire_ms)),
        ]
    }
}

/// All of them.
#[derive(Debug, Default)]
pub struct Summary {
    rows: Vec<RecordedTrajectory>,
}

/// Whether an event is more than the course of things.
fn is_trouble(event: &Event) -> bool {
    event.kind != EventKind::Run
}

/// The log next to a recording; empty where there is none.
fn events_of(out: &Path) -> Vec<Event> {
    let text = std::fs::read_to_string(events_path(out)).unwrap_or_default();
    text.lines().filter_map(|line| json::from_text(line).ok()).collect()
}

impl Summary {
    /// A trajectory that was recorded now.
    pub fn add(&mut self, job: &Job, outcome: &Outcome) {
        let troubles: Vec<&Event> = outcome.events.iter().filter(|event| is_trouble(event)).collect();
        for event in &troubles {
            let servo = event.servo.map_or_else(String::new, |id| format!("servo {id}: "));
            tracing::debug!("{}: {:.3} s: {servo}{}", job.name, event.time_s, event.message);
        }
        let n_held = troubles.iter().filter(|event| event.kind == EventKind::Hold).count().div_ceil(2);
        if n_held > 0 {
            tracing::warn!(
                "{}: load limiting acted on a tendon {n_held} times; {} says when and how far",
                job.name,
                events_path(&job.out).display()
            );
        }
        if let Some(missed) = outcome.stats.missed_cycles() {
            tracing::warn!("{}: {missed}; rows without a cycle are filled in and marked as gaps", job.name);
        }
        self.rows.push(RecordedTrajectory {
            name: job.name.clone(),
            role: job.role.clone(),
            rows: outcome.n_rows,
            filled_in: outcome.n_gaps,
            events: troubles.len(),
            // A simulated clock is never late.
            timing: Some(outcome.stats.summary()).filter(|timing| timing.wire_ms > 0.0),
            out: job.out.clone(),
            order: job.order,
        });
    }

    /// A trajectory that was there already.
    pub fn add_there(&mut self, job: &Job, recording: &Recording) {
        self.rows.push(RecordedTrajectory {
            name: job.name.clone(),
            role: job.role.clone(),
            rows: recording.n_samples(),
            filled_in: recording.gap().iter().filter(|gap| **gap).count(),
            events: events_of(&job.out).iter().filter(|event| is_trouble(event)).count(),
            timing: None,
            out: job.out.clone(),
            order: job.order,
        });
    }

    /// In the order of the plan, which threads do not keep.
    pub fn sort(&mut self) {
        self.rows.sort_by_key(|row| row.order);
    }

    /// Samples in all recordings.
    pub fn n_rows(&self) -> usize {
        self.rows.iter().map(|row| row.rows).sum()
    }

    /// Names and recordings.
    pub fn recordings(&self) -> anyhow::Result<Vec<(String, Recording)>> {
        self.rows.iter().map(|row| Ok((row.name.clone(), Recording::read(&row.out)?))).collect()
    }

    /// Provenance of the first recording.
    pub fn first_meta(&self) -> anyhow::Result<Metadata> {
        match self.rows.first() {
            Some(row) => Ok(Recording::read_metadata(&row.out)?),
            None => Ok(Metadata::default()),
        }
    }

    /// The rows, for a file.
    pub fn rows(&self) -> &[RecordedTrajectory] {
        &self.rows
    }

    /// Prints one line per trajectory.
    pub fn print(&self, context: &Context) {
        if self.rows.is_empty() {
            return;
        }
        let line = |cells: &[String]| {
            let (name, rest) = (&cells[0], &cells[1..]);
            let rest: String = rest.iter().map(|cell| format!("{cell:>14}")).collect();
            format!("{name:<16}{rest}")
        };
        let headings = ["trajectory", "role", "samples", "filled in", "events", "late p99 [ms]", "bus [ms]"]
            .map(String::from);
        context.print(line(&headings));
        self.rows.iter().for_each(|row| context.print(line(&row.cells())));
        context.print(format_args!("samples: {}, recordings: {}", self.n_rows(), self.rows.len()));
    }
}
