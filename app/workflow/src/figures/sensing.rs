//! The report of forces that were estimated without a sensor.

use std::path::Path;

use hysteron_base::{Recording, json};
use hysteron_report::figure::{register_embedded_font, save};
use hysteron_report::lines::{Curve, Shaded, TimeChart, TimePanel, spans};
use hysteron_report::page::{Page, write_metrics, write_page};
use hysteron_twin::sense::ForceSensor;
use serde::Serialize;
use serde_json::Value;

use crate::shared::inputs::Input;
use crate::shared::recording_checks::Findings;
use crate::tendon::sense::Scores;
use crate::{COMMIT, Context};

/// Everything the report may show.
pub(crate) struct Shown<'a> {
    /// Of what, for the title.
    pub title: &'a str,
    /// The estimates.
    pub recording: &'a Recording,
    /// Recording that they were estimated from.
    pub input: &'a Input,
    /// How good they are, where the truth is known.
    pub scores: &'a Scores,
    /// Sensor that made the estimates.
    pub sensor: &'a ForceSensor,
    /// Warnings about the recording.
    pub findings: &'a Findings,
}

#[derive(Serialize)]
struct Metrics<'a> {
    format: &'static str,
    version: u32,
    scores: &'a Scores,
    sensor: &'a ForceSensor,
    /// Warnings about its recordings.
    recording_warnings: &'a Findings,
    recording: &'a str,
    recording_sha256: &'a str,
    command: &'a str,
    commit: &'static str,
}

/// Writes the figures, `report.html` and `metrics.json` to `folder`.
pub(crate) fn write(
    folder: &Path,
    shown: &Shown,
    context: &Context,
    with_png: bool,
) -> anyhow::Result<Value> {
    register_embedded_font()?;
    let value = write_metrics(folder, &metrics(shown, context))?;
    let about = "Tensions at the pulleys and the force on the tip, told from strokes, loads, tip and twin.";
    let mut page =
        Page::new(&format!("{}: forces of {}", shown.title, shown.input.name), about, &context.command);
    results(&mut page, shown.scores);
    page.heading("Figures");
    page.figure(&save(folder, &force(shown), with_png)?);
    page.figure(&save(folder, &tensions(shown), with_png)?);
    shown.findings.show(&mut page);
    write_page(folder, page.finish(COMMIT))?;
    Ok(value)
}

/// The summary, where no report is asked for.
pub(crate) fn summarise(shown: &Shown, context: &Context) -> anyhow::Result<Value> {
    Ok(json::to_value(metrics(shown, context))?)
}

fn metrics<'a>(shown: &Shown<'a>, context: &'a Context) -> Metrics<'a> {
    Metrics {
        format: "hysteron-metrics",
        version: 1,
        scores: shown.scores,
        sensor: shown.sensor,
        recording_warnings: shown.findings,
        recording: &shown.input.name,
        recording_sha256: &shown.input.hash,
        command: &context.command,
        commit: COMMIT,
    }
}

fn results(page: &mut Page, scores: &Scores) {
    page.heading("Results");
    let percent = |share: f64| format!("{:.1}", 100.0 * share);
    if !scores.tensions.is_empty() {
        page.paragraph("Tensions: root mean square of the error over that of the tension.");
        let rows = scores.tensions.iter().map(|row| {
            vec![row.method.to_owned(), percent(row.all), percent(row.moving), percent(row.resting)]
        });
        page.table(&["method", "all [%]", "moving [%]", "at rest [%]"], rows);
    }
    if !scores.forces.is_empty() {
        page.paragraph("Force on the tip, 0.3 s after a contact has begun.");
        let rows = scores.forces.iter().map(|row| {
            vec![
                row.method.to_owned(),
                row.samples.to_owned(),
                row.n.to_string(),
                format!("{:.0}", 1e3 * row.rms_n),
                format!("{:.0}", 1e3 * row.median_n),
                percent(row.near),
                percent(row.aligned),
            ]
        });
        let headings = [
            "method",
            "samples",
            "number",
            "RMS [mN]",
            "median [mN]",
            "within 30 mN or 15 % [%]",
            "direction within 15° [%]",
        ];
        page.table(&headings, rows);
    }
    match &scores.contacts {
        Some(contacts) => page.list([
            ("Contacts", contacts.contacts.to_string()),
            ("Found within 100 ms [%]", percent(contacts.found_at_once)),
            ("Above 0.15 N, found within 100 ms [%]", percent(contacts.strong_found_at_once)),
            ("False alarms an hour", format!("{:.1}", contacts.false_alarms_per_hour)),
            ("Time without contact [s]", format!("{:.0}", contacts.free_s)),
            ("Contact claimed in it [%]", percent(contacts.claimed)),
        ]),
        None => page
            .paragraph("No true force or tension was recorded, so nothing says how good the estimates are."),
    }
}

/// Estimate in the first colour, truth beneath in the second.
fn beside_truth(label: String, estimate: &[f64], truth: Option<&[f64]>) -> TimePanel {
    let mut curves = Vec::new();
    if let Some(truth) = truth {
        curves.push(Curve { width: 2.0, ..Curve::new("true", 1, truth.to_vec()) });
    }
    curves.push(Curve { width: 1.2, ..Curve::new("told", 0, estimate.to_vec()) });
    TimePanel::new(label, curves)
}

/// Force on the tip over time, contacts shaded.
fn force(shown: &Shown) -> TimeChart {
    let recording = shown.recording;
    let truth = |axis: &str| {
        let of = |stem: &str| shown.input.recording.channel(&format!("{stem}_{axis}_n"));
        of("tip_force").or_else(|| of("true_tip_force"))
    };
    let panels = ["x", "y", "z"].into_iter().filter_map(|axis| {
        let estimate = recording.channel(&format!("tip_force_{axis}_n"))?;
        Some(beside_truth(format!("{axis} [N]"), estimate, truth(axis)))
    });
    let caption = "Force of the surroundings on the tip [N], in the frame in which the tip is recorded, over time [s]. Shaded: a contact \
                   is claimed. A force along a straight body hardly moves the tip and is not seen.";
    let time = recording.time();
    let chart = TimeChart::over_time("force", "Force on the tip", caption, time, panels.collect());
    let contact: Vec<bool> =
        recording.channel("contact").unwrap_or_default().iter().map(|contact| *contact > 0.0).collect();
    TimeChart { shaded: vec![Shaded { name: "contact".into(), spans: spans(time, &contact) }], ..chart }
}

/// Tension of every tendon over time.
fn tensions(shown: &Shown) -> TimeChart {
    let truth = shown.input.recording.numbered("true_tension", "n");
    let panels = shown.recording.numbered("tension", "n").into_iter().enumerate();
    let panels = panels
        .map(|(k, tension)| beside_truth(format!("tendon {} [N]", k + 1), tension, truth.get(k).copied()));
    let caption = "Tension of every tendon at its pulley [N], over time [s].";
    TimeChart::over_time(
        "tensions",
        "Tensions at the pulleys",
        caption,
        shown.recording.time(),
        panels.collect(),
    )
}
