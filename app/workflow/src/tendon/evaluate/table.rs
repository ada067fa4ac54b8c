//! The numbers of recordings that followed a target, and their table.

use hysteron_actuator::health::Health;
use hysteron_base::Recording;
use hysteron_control::TargetPath;
use hysteron_control::tracking::{Repeatability, TrackedTip, TrackingScore, repeatability};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::shared::recording_checks::Findings;

/// One recording and its score.
#[derive(Debug, Clone)]
pub struct Row {
    /// Its name.
    pub name: String,
    /// The result that it is a repeat of, where results are compared.
    pub result: Option<String>,
    /// SHA-256 of its file.
    pub sha256: String,
    /// Its provenance.
    pub source: String,
    /// Its score.
    pub score: TrackingScore,
    /// Its path, in the target's frame.
    pub tracked: TrackedTip,
}

/// One metric: its heading, the factor to the unit shown, digits, and its field.
pub struct Metric {
    /// Heading, with unit.
    pub heading: &'static str,
    /// Key in `metrics.json`.
    pub key: &'static str,
    scale: f64,
    digits: usize,
    of: fn(&TrackingScore) -> Option<f64>,
}

/// Metrics of the table, in order.
pub const METRICS: [Metric; 8] = [
    metric("RMSE [mm]", "rmse_m", 1e3, 3, |score| Some(score.rmse_m)),
    metric("NRMSE [%]", "nrmse", 100.0, 2, |score| score.nrmse),
    metric("IoU", "iou", 1.0, 4, |score| score.iou),
    metric("Chamfer [mm]", "chamfer_m", 1e3, 3, |score| Some(score.chamfer_m)),
    metric("Hausdorff [mm]", "hausdorff_m", 1e3, 3, |score| Some(score.hausdorff_m)),
    metric("Fréchet [mm]", "frechet_m", 1e3, 3, |score| Some(score.frechet_m)),
    metric("Aligned RMSE [mm]", "aligned_rmse_m", 1e3, 3, |score| score.aligned_rmse_m),
    metric("Lag [ms]", "lag_s", 1e3, 0, |score| score.lag_s),
];

const fn metric(
    heading: &'static str,
    key: &'static str,
    scale: f64,
    digits: usize,
    of: fn(&TrackingScore) -> Option<f64>,
) -> Metric {
    Metric { heading, key, scale, digits, of }
}

impl Metric {
    /// A value as shown; a dash where there is none.
    fn cell(&self, value: Option<f64>) -> String {
        value.map_or("-".to_owned(), |value| format!("{:.*}", self.digits, self.scale * value))
    }

    /// Its mean and spread over repeats.
    pub fn repeatability(&self, rows: &[Row]) -> Option<Repeatability> {
        let scores: Vec<TrackingScore> = rows.iter().map(|row| row.score).collect();
        repeatability(&scores, self.of)
    }
}

/// The recordings of each result, in order.
pub fn results(rows: &[Row]) -> impl Iterator<Item = &[Row]> {
    rows.chunk_by(|a, b| a.result == b.result)
}

/// The table, without its headings: a row per recording, and for repeats of one result their mean and variation.
pub fn cells(rows: &[Row]) -> Vec<Vec<String>> {
    let line = |name: String, cell: &dyn Fn(&Metric) -> String| {
        [name].into_iter().chain(METRICS.iter().map(cell)).collect::<Vec<_>>()
    };
    let mut table = Vec::new();
    for rows in results(rows) {
        let own =
            rows.iter().map(|row| line(row.name.clone(), &|metric| metric.cell((metric.of)(&row.score))));
        table.extend(own);
        if rows.len() == 1 {
            continue;
        }
        let of = |metric: &Metric| metric.repeatability(rows);
        let percent = |part: f64| format!("{:.1} %", 100.0 * part);
        let name =
            |what: &str| rows[0].result.as_ref().map_or(what.to_owned(), |name| format!("{name}, {what}"));
        table.push(line(name("mean"), &|metric| metric.cell(of(metric).map(|it| it.mean))));
        table.push(line(name("CV"), &|metric| {
            of(metric).and_then(|it| it.variation).map_or("-".to_owned(), percent)
        }));
    }
    table
}

/// Headings of [`cells`].
pub fn headings() -> Vec<&'static str> {
    ["Recording"].into_iter().chain(METRICS.iter().map(|metric| metric.heading)).collect()
}

/// Metadata of the strokes of a tracked path.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Commanded {
    /// Part of the samples in which a network was outside what it had seen in training [-].
    pub extrapolating: f64,
    /// Part of the samples in which a limit reduced a stroke [-].
    pub limited: f64,
    /// Health of the servos from the recordings, in a section of its own.
    #[serde(skip)]
    pub health: Option<Health>,
}

impl Commanded {
    /// Of a recording by `hysteron command`.
    pub fn of(strokes: &Recording) -> Self {
        let part = |flag: &str| {
            strokes
                .channel(flag)
                .map_or(0.0, |values| values.iter().sum::<f64>() / values.len().max(1) as f64)
        };
        Self { extrapolating: part("extrapolating"), limited: part("limited"), health: None }
    }
}

/// Recordings of a target with their scores, and all that is reported with them.
#[derive(Clone, Copy)]
pub(crate) struct ScoredRecordings<'a> {
    /// Target path.
    pub target: &'a TargetPath,
    /// Metrics of each recording.
    pub rows: &'a [Row],
    /// Metadata of commanded strokes, if they were.
    pub commanded: Option<&'a Commanded>,
    /// Warnings about the recordings.
    pub findings: &'a Findings,
}
