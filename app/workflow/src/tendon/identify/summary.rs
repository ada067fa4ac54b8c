//! Results of identifications, for the terminal and the report.

use crate::Context;
use std::path::Path;

use hysteron_base::{BadInput, Recording, json};
use hysteron_twin::coreact::{DistanceSummary, IdentificationSummary};
use serde::Serialize;

/// One recording.
#[derive(Debug, Serialize)]
pub struct Row {
    /// Its name.
    pub name: String,
    /// Result of its identification.
    #[serde(flatten)]
    pub summary: IdentificationSummary,
}

impl Row {
    /// Headings of [`Row::cells`].
    pub const HEADINGS: [&'static str; 7] = [
        "Recording",
        "Samples (filled in)",
        "Without [mm]: median, p99",
        "With [mm]: median, p99, max",
        "Strokes at a bound [%]: lower, upper, rate",
        "Samples with one [%]: lower, upper, rate",
        "QPs solved, not solved",
    ];

    /// Out of a recording that was identified earlier.
    pub fn read(path: &Path) -> anyhow::Result<Self> {
        let recording = Recording::read(path)?;
        let text = recording.meta().extra.get("identify.summary").map_or("", String::as_str);
        let summary = json::from_text(text).map_err(|error| {
            BadInput::new(path.display().to_string(), "the summary of an identification", error.to_string())
        })?;
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        Ok(Self { name, summary })
    }

    /// The numbers as text.
    pub fn cells(&self) -> Vec<String> {
        let s = &self.summary;
        let DistanceSummary { median_m, p99_m, max_m, .. } = s.after;
        let mm =
            |metres: &[f64]| metres.iter().map(|m| format!("{:.3}", 1e3 * m)).collect::<Vec<_>>().join(", ");
        let percent = |parts: [f64; 3]| parts.map(|part| format!("{:.1}", 100.0 * part)).join(", ");
        vec![
            self.name.clone(),
            format!("{} ({})", s.samples, s.gaps),
            mm(&[s.before.median_m, s.before.p99_m]),
            mm(&[median_m, p99_m, max_m]),
            percent(s.share_at_bound),
            percent(s.samples_at_bound.map(|count| count as f64 / s.samples as f64)),
            format!("{}, {}", s.qps[0], s.qps[1..].iter().sum::<usize>()),
        ]
    }
}

/// Prints one line per recording.
pub fn print(rows: &[Row], context: &Context) {
    for Row { name, summary } in rows {
        let mm = |metres: f64| 1e3 * metres;
        context.print(format_args!(
            "{name}: tip off by {:.3} mm in the median without, {:.3} mm with (99 %: {:.3} mm)",
            mm(summary.before.median_m),
            mm(summary.after.median_m),
            mm(summary.after.p99_m),
        ));
    }
}
