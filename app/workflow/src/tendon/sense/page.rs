//! The page of `sense`: scores, and estimates over time next to what is true.

use hysteron_base::Recording;
use hysteron_report::folder::ReportFolder;
use hysteron_report::lines::{Curve, Shaded, TimeChart, TimePanel, spans};
use hysteron_report::page::Page;
use hysteron_twin::sense::SensingScores;

use super::outcome::Outcome;
use crate::shared::recording_checks;

/// The series that are drawn.
pub(super) struct EstimateSeries<'a> {
    /// Name of the robot, for the title.
    pub title: &'a str,
    /// The estimates.
    pub estimates: &'a Recording,
    /// Recording that they were estimated from.
    pub measured: &'a Recording,
}

/// Writes the figures, `report.html` and `metrics.json` to `folder`.
pub(super) fn write(folder: &ReportFolder, outcome: &Outcome, shown: &EstimateSeries) -> anyhow::Result<()> {
    folder.write_metrics(outcome)?;
    let about =
        "Tensions at the pulleys and the force on the tip, estimated from strokes, loads, tip and twin.";
    let conclusion = match outcome.scores.forces.first() {
        Some(score) => {
            format!("The force on the tip is {:.3} N off in the median ({}).", score.median_n, score.method)
        }
        None => "Tensions and force were estimated; no force was measured to compare them with.".to_owned(),
    };
    let title = format!("{}: forces of {}", shown.title, outcome.recording);
    let mut page = Page::concluded(&title, &conclusion, about, &outcome.command);
    results(&mut page, &outcome.scores);
    page.heading("Figures");
    folder.add(&mut page, &force(shown))?;
    folder.add(&mut page, &tensions(shown))?;
    recording_checks::show(&outcome.recording_warnings, &mut page);
    folder.write_page(page, &outcome.commit)
}

fn results(page: &mut Page, scores: &SensingScores) {
    page.heading("Results");
    let percent = |share: f64| format!("{:.1}", 100.0 * share);
    if !scores.tensions.is_empty() {
        page.paragraph("Tensions: root mean square of the error over that of the tension.");
        let rows = scores.tensions.iter().map(|row| {
            vec![row.method.to_string(), percent(row.all), percent(row.moving), percent(row.resting)]
        });
        page.table(&["method", "all [%]", "moving [%]", "at rest [%]"], rows);
    }
    if !scores.forces.is_empty() {
        page.paragraph("Force on the tip, 0.3 s after a contact has begun.");
        let rows = scores.forces.iter().map(|row| {
            vec![
                row.method.to_string(),
                row.samples.to_string(),
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
            .paragraph("No true force or tension was recorded, so the accuracy of the estimates is unknown."),
    }
}

/// Estimate in the first colour, truth beneath in the second.
fn with_truth(label: String, estimate: &[f64], truth: Option<&[f64]>) -> TimePanel {
    let mut curves = Vec::new();
    if let Some(truth) = truth {
        curves.push(Curve { width: 2.0, ..Curve::new("true", 1, truth.to_vec()) });
    }
    curves.push(Curve { width: 1.2, ..Curve::new("estimated", 0, estimate.to_vec()) });
    TimePanel::new(label, curves)
}

/// Force on the tip over time, contacts shaded.
fn force(shown: &EstimateSeries) -> TimeChart {
    let recording = shown.estimates;
    let truth = |axis: &str| {
        let of = |stem: &str| shown.measured.channel(&format!("{stem}_{axis}_n"));
        of("tip_force").or_else(|| of("true_tip_force"))
    };
    let panels = ["x", "y", "z"].into_iter().filter_map(|axis| {
        let estimate = recording.channel(&format!("tip_force_{axis}_n"))?;
        Some(with_truth(format!("{axis} [N]"), estimate, truth(axis)))
    });
    let caption = "Force of the surroundings on the tip [N], in the frame in which the tip is recorded, over time [s]. Shaded: a contact \
                   is claimed. A force along a straight body hardly moves the tip and is not detected.";
    let time = recording.time();
    let chart = TimeChart::over_time("force", "Force on the tip", caption, time, panels.collect());
    let contact: Vec<bool> =
        recording.channel("contact").unwrap_or_default().iter().map(|contact| *contact > 0.0).collect();
    TimeChart { shaded: vec![Shaded { name: "contact".into(), spans: spans(time, &contact) }], ..chart }
}

/// Tension of every tendon over time.
fn tensions(shown: &EstimateSeries) -> TimeChart {
    let truth = shown.measured.numbered("true_tension", "n");
    let panels = shown.estimates.numbered("tension", "n").into_iter().enumerate();
    let panels = panels
        .map(|(k, tension)| with_truth(format!("tendon {} [N]", k + 1), tension, truth.get(k).copied()));
    let caption = "Tension of every tendon at its pulley [N], over time [s].";
    TimeChart::over_time(
        "tensions",
        "Tensions at the pulleys",
        caption,
        shown.estimates.time(),
        panels.collect(),
    )
}
