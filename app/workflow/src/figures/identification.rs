//! The report of an identification: errors without and with auxiliary tendons, and their strokes over time.

use std::path::Path;

use hysteron_base::Recording;
use serde::Serialize;
use serde_json::Value;

use crate::shared::recording_checks::Findings;
use crate::shared::verdict::ratio;
use crate::tendon::identify::summary::Row;
use crate::{COMMIT, Context};
use hysteron_report::figure::{register_embedded_font, save};
use hysteron_report::lines::TimeChart;
use hysteron_report::page::{Page, write_metrics, write_page};
use hysteron_report::series::{MEASURED, TWIN, TipSeries, UNCORRECTED, error_panel, millimetres, tip_panels};
use hysteron_report::strokes::auxiliary_strokes;
use hysteron_report::verdict::{Criterion, Verdict};

/// Recordings that are drawn at most: those with the largest error that is left.
const MAX_RECORDINGS: usize = 4;

#[derive(Serialize)]
struct Metrics<'a> {
    format: &'static str,
    version: u32,
    /// Whether a network can learn from the strokes.
    verdict: Verdict,
    recordings: &'a [Row],
    /// Recordings that were not used, and why.
    left_out: &'a [String],
    /// Warnings about its recordings.
    recording_warnings: &'a Findings,
    scene_sha256: &'a str,
    command: &'a str,
    commit: &'a str,
}

/// How the auxiliary strokes were chosen.
#[derive(Clone, Copy)]
pub enum Chosen {
    /// One QP a sample.
    ByQps,
    /// A network that was there already.
    ByNetwork,
}

/// Content of the report.
#[derive(Clone, Copy)]
pub(crate) struct Shown<'a> {
    /// Title of the page.
    pub title: &'a str,
    /// How the auxiliary strokes were chosen.
    pub chosen: Chosen,
    /// Hash of the scene.
    pub scene_sha256: &'a str,
    /// The recordings that were identified.
    pub rows: &'a [Row],
    /// Recordings that were not used, and why.
    pub left_out: &'a [String],
    /// Warnings about the recordings.
    pub findings: &'a Findings,
}

/// Writes the figures of the recordings in `folder`, `report.html` and `metrics.json` to it.
pub(crate) fn write(folder: &Path, shown: &Shown, context: &Context) -> anyhow::Result<Value> {
    register_embedded_font()?;
    let Shown { title, chosen, scene_sha256, rows, left_out, findings } = *shown;
    let (command, commit) = (context.command.clone(), COMMIT);
    let metrics = Metrics {
        format: "hysteron-metrics",
        version: 1,
        verdict: verdict(rows, left_out),
        recordings: rows,
        left_out,
        recording_warnings: findings,
        scene_sha256,
        command: &command,
        commit,
    };
    let value = write_metrics(folder, &metrics)?;
    let about = match chosen {
        Chosen::ByQps => {
            "Distance of the twin's tip from the measured one, without and with auxiliary tendons, and how often their bounds \
             are active. One QP per sample found the auxiliary strokes."
        }
        Chosen::ByNetwork => {
            "Distance of the twin's tip from the measured one, without auxiliary tendons and with the auxiliary strokes of a \
             network. The error that is left is the training data of a second network; no QP was solved."
        }
    };
    let mut page = Page::judged(title, &metrics.verdict, about, &command);
    page.heading("Results");
    page.table(&Row::HEADINGS, rows.iter().map(Row::cells));
    if !left_out.is_empty() {
        page.table(&["Left out"], left_out.iter().map(|why| vec![why.clone()]));
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
        let recording = Recording::read(folder.join(format!("{}.parquet", row.name)))?;
        for chart in charts(&row.name, &recording) {
            page.figure(&save(folder, &chart, false)?);
        }
    }
    findings.show(&mut page);
    page.small(&format!("Scene {scene_sha256}."));
    write_page(folder, page.finish(commit))?;
    context.reported(folder);
    Ok(value)
}

/// Whether a network can learn from the auxiliary strokes of these recordings.
fn verdict(rows: &[Row], left_out: &[String]) -> Verdict {
    let samples: usize = rows.iter().map(|row| row.summary.samples).sum();
    if samples == 0 {
        return Verdict::on("").because(Criterion::Missing, 1.0, "no recording was identified").verdict();
    }
    let rms = |of: fn(&Row) -> f64| {
        let squares = rows.iter().map(|row| row.summary.samples as f64 * of(row).powi(2)).sum::<f64>();
        (squares / samples as f64).sqrt()
    };
    let (before, after) = (rms(|row| row.summary.before.rms_m), rms(|row| row.summary.after.rms_m));
    let qps = |range: std::ops::Range<usize>| -> f64 {
        rows.iter().flat_map(|row| &row.summary.qps[range.clone()]).sum::<usize>() as f64
    };
    let (solved, not) = (qps(0..1), qps(1..4));
    let at_bound: usize =
        rows.iter().map(|row| row.summary.samples_at_bound.iter().copied().max().unwrap_or(0)).sum();
    let at_bound = at_bound as f64 / samples as f64;
    let mm = |m: f64| format!("{:.3} mm", 1e3 * m);
    let n = rows.len() + left_out.len();
    Verdict::on(format!("auxiliary tendons bring the twin's tip within {} of the measured one", mm(after)))
        .because(
            Criterion::ErrorOverBaseline,
            ratio(after, before),
            format!("the tip is off by {} with auxiliary tendons, {} without (RMS)", mm(after), mm(before)),
        )
        .because(
            Criterion::SolverFailures,
            if solved + not > 0.0 { not / (solved + not) } else { 0.0 },
            format!("{not:.0} of {:.0} QPs were not solved", solved + not),
        )
        .because(
            Criterion::AtLimit,
            at_bound,
            format!("auxiliary strokes stand at a bound in {:.1} % of the samples", 100.0 * at_bound),
        )
        .because(
            Criterion::Missing,
            left_out.len() as f64 / n.max(1) as f64,
            format!("{} of {n} recordings were left out", left_out.len()),
        )
        .verdict()
}

/// The recordings with the largest error that is left, in their own order.
fn largest_errors(rows: &[Row]) -> Vec<&Row> {
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
