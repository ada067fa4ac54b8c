//! The page of `identify-servo`: friction over its cloud of data, what is left, tensions at reversals.

use hysteron_report::folder::ReportFolder;
use hysteron_report::scatter::{Marks, Scatter, ScatterChart};

use super::found::IdentifiedPulley;
use super::outcome::Outcome;
use crate::shared::identification::ESTIMATE_HEADINGS;
use crate::shared::identification_page::{
    JointSeries, begin, errors_over_speed, errors_over_time, finish, friction_curves,
};

/// Writes the figures, `report.html` and `metrics.json` to `folder`.
pub(super) fn write(
    folder: &ReportFolder,
    found: &[IdentifiedPulley],
    outcome: &Outcome,
) -> anyhow::Result<()> {
    let about = format!(
        "Load scale, friction by the law {} at speeds that were recorded, and backlash of {} servos.",
        outcome.law,
        found.len()
    );
    let mut page = begin(folder, outcome, &outcome.verdict, ("Identified servos", &about, &outcome.command))?;
    for servo in found {
        page.heading(&format!("Servo {}", servo.number));
        match &servo.pulley {
            Ok(pulley) => page.list([
                ("Samples of steady motion", pulley.samples.len().to_string()),
                ("Misfit of the law, 1 for none [-]", format!("{:.2}", pulley.misfit)),
            ]),
            Err(bad) => page.paragraph(&format!("Friction cannot be estimated: {bad}")),
        }
        page.table(&ESTIMATE_HEADINGS, servo.rows.iter().map(|row| row.estimate().cells()));
    }
    page.heading("Figures");
    let servos: Vec<JointSeries> = found.iter().filter_map(series).collect();
    for chart in [friction_curves(&servos), errors_over_speed(&servos)] {
        folder.add(&mut page, &chart)?;
    }
    for chart in errors_over_time(&servos) {
        folder.add(&mut page, &chart)?;
    }
    let gaps: Vec<Scatter> = found.iter().filter_map(reversals).collect();
    if !gaps.is_empty() {
        let chart = ScatterChart {
            name: "backlash".into(),
            title: "Tension after reversals".into(),
            caption: "Tension over how far the pulley has turned back, each reversal relative to the tension with which it began. It stays \
                      until the gap between pulley and tendon is crossed: the line."
                .into(),
            tiles: gaps,
        };
        folder.add(&mut page, &chart)?;
    }
    finish(folder, page, &outcome.recording_warnings)
}

fn series(servo: &IdentifiedPulley) -> Option<JointSeries> {
    let pulley = servo.pulley.as_ref().ok()?;
    let measured: Vec<f64> = pulley.friction.clone();
    let predicted = measured.iter().zip(&pulley.residuals).map(|(m, left)| m - left).collect();
    let velocity = pulley.samples.velocity.clone();
    let name = format!("servo {}", servo.number);
    Some(JointSeries::new(name, [velocity, measured, predicted], &|v| servo.friction(v)))
}

fn reversals(servo: &IdentifiedPulley) -> Option<Scatter> {
    let backlash = servo.backlash.as_ref().ok()?;
    let mm = 1e3 * servo.radius;
    let (mut way, mut tension) = (Vec::new(), Vec::new());
    for reversal in &backlash.reversals {
        let first = reversal.course.first().map_or(1.0, |[_, tension]| *tension);
        way.extend(reversal.course.iter().map(|[u, _]| mm * u));
        tension.extend(reversal.course.iter().map(|[_, tension]| tension / first));
    }
    let width = mm * backlash.width;
    Some(Scatter {
        x_name: format!("servo {}: turned back [mm]", servo.number),
        y_name: "tension over that of the reversal [-]".into(),
        marks: vec![
            Marks::dots("samples", 5, &way, &tension),
            Marks::line("width of the gap", 1, &[width, width], &[0.7, 1.0]),
        ],
    })
}
