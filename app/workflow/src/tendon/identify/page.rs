//! The page of `identify`: errors without and with auxiliary tendons, and their strokes over time.

use hysteron_base::Recording;
use hysteron_report::folder::ReportFolder;
use hysteron_report::lines::TimeChart;
use hysteron_report::page::Page;
use hysteron_report::series::{MEASURED, TWIN, TipSeries, UNCORRECTED, error_panel, millimetres, tip_panels};
use hysteron_report::strokes::auxiliary_strokes;
use hysteron_twin::coreact::DistanceSummary;

use super::outcome::{IdentifiedRecording, Outcome};
use crate::shared::recording_checks;

/// Recordings that are drawn at most: those with the largest error that is left.
const MAX_RECORDINGS: usize = 4;

/// How the auxiliary strokes were chosen.
#[derive(Clone, Copy)]
pub(super) enum StrokeChoice {
    /// One QP a sample.
    ByQps,
    /// A network that was there already.
    ByNetwork,
}

/// Headings of [`cells`].
const HEADINGS: [&str; 7] = [
    "Recording",
    "Samples (filled in)",
    "Without [mm]: median, p99",
    "With [mm]: median, p99, max",
    "Strokes at a bound [%]: lower, upper, rate",
    "Samples with one [%]: lower, upper, rate",
    "QPs solved, not solved",
];

/// Writes the figures of the recordings in `folder`, `report.html` and `metrics.json` to it.
pub(super) fn write(
    folder: &ReportFolder,
    title: &str,
    policy: StrokeChoice,
    outcome: &Outcome,
) -> anyhow::Result<()> {
    folder.write_metrics(outcome)?;
    let rows = &outcome.recordings;
    let about = match policy {
        StrokeChoice::ByQps => {
            "Distance of the twin's tip from the measured one, without and with auxiliary tendons, and how often their bounds \
             are active. One QP per sample found the auxiliary strokes."
        }
        StrokeChoice::ByNetwork => {
            "Distance of the twin's tip from the measured one, without auxiliary tendons and with the auxiliary strokes of a \
             network. The error that is left is the training data of a second network; no QP was solved."
        }
    };
    let mut page = Page::with_verdict(title, &outcome.verdict, about, &outcome.command);
    page.heading("Results");
    page.table(&HEADINGS, rows.iter().map(cells));
    if !outcome.left_out.is_empty() {
        page.table(&["Left out"], outcome.left_out.iter().map(|why| vec![why.clone()]));
    }
    page.heading("Figures");
    let shown = largest_errors(rows);
    if shown.len() < rows.len() {
        page.paragraph(&format!(
            "The {} of {} recordings with the largest error that is left (99th percentile).",
            shown.len(),
            rows.len()
        ));
    }
    for row in shown {
        let recording = Recording::read(folder.path.join(format!("{}.parquet", row.name)))?;
        for chart in charts(&row.name, &recording) {
            folder.add(&mut page, &chart)?;
        }
    }
    recording_checks::show(&outcome.recording_warnings, &mut page);
    page.small(&format!("Scene {}.", outcome.scene_sha256));
    folder.write_page(page, &outcome.commit)
}

/// The recordings with the largest error that is left, in their own order.
fn largest_errors(rows: &[IdentifiedRecording]) -> Vec<&IdentifiedRecording> {
    let mut order: Vec<usize> = (0..rows.len()).collect();
    order.sort_by(|a, b| rows[*b].summary.after.p99_m.total_cmp(&rows[*a].summary.after.p99_m));
    order.truncate(MAX_RECORDINGS);
    order.sort_unstable();
    order.into_iter().map(|k| &rows[k]).collect()
}

/// Tips, their errors and the auxiliary strokes of a recording.
fn charts(name: &str, recording: &Recording) -> Vec<TimeChart> {
    let tip = |stem: &str| -> Vec<&[f64]> {
        ["x", "y", "z"].iter().map_while(|axis| recording.channel(&format!("{stem}_{axis}_m"))).collect()
    };
    let time = recording.time();
    let measured = TipSeries::new("measured", MEASURED, &tip("tip")).without_gaps(recording.gap());
    let twins = [("uncorrected twin", UNCORRECTED, "bare"), ("twin with auxiliary tendons", TWIN, "twin")]
        .map(|(name, color, stem)| TipSeries::new(name, color, &tip(stem)));
    let errors = TimeChart::over_time(
        format!("{name}-error"),
        format!("{name}: error of the tip"),
        "Distance of the twin's tip from the measured one [mm] over time [s], without and with auxiliary tendons.",
        time,
        vec![error_panel(&measured, &twins)],
    );
    let [uncorrected, corrected] = twins;
    let tips = TimeChart::over_time(
        format!("{name}-tip"),
        format!("{name}: tip"),
        "Tip as measured, of the twin without and of the twin with auxiliary tendons [mm], over time [s]; interrupted where \
         nothing was measured. Each axis has its own scale.",
        time,
        tip_panels(&[measured, uncorrected, corrected]),
    );
    let strokes = auxiliary_strokes(time, recording.aux().into_iter().map(millimetres).collect());
    let strokes = TimeChart {
        name: format!("{name}-auxiliary-strokes"),
        title: format!("{name}: auxiliary strokes"),
        ..strokes
    };
    vec![tips, errors, strokes]
}

/// The numbers of a recording as text.
fn cells(row: &IdentifiedRecording) -> Vec<String> {
    let s = &row.summary;
    let DistanceSummary { median_m, p99_m, max_m, .. } = s.after;
    let mm = |metres: &[f64]| metres.iter().map(|m| format!("{:.3}", 1e3 * m)).collect::<Vec<_>>().join(", ");
    let percent = |parts: [f64; 3]| parts.map(|part| format!("{:.1}", 100.0 * part)).join(", ");
    vec![
        row.name.clone(),
        format!("{} ({})", s.samples, s.gaps),
        mm(&[s.before.median_m, s.before.p99_m]),
        mm(&[median_m, p99_m, max_m]),
        percent(s.share_at_bound),
        percent(s.samples_at_bound.map(|count| count as f64 / s.samples as f64)),
        format!("{}, {}", s.qps[0], s.qps[1..].iter().sum::<usize>()),
    ]
}
