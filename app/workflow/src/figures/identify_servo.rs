//! The report of `identify-servo`: friction over its cloud of data, what is left, tensions at reversals.

use std::path::Path;

use hysteron_report::figure::save;
use hysteron_report::scatter::{Marks, Scatter, ScatterChart};

use super::arm_identification::{
    JointSeries, errors_over_speed, errors_over_time, finish, friction_curves, page,
};
use crate::Context;
use crate::arm::identify::Summary;
use crate::rig::identify_servo::Found;

/// Writes the figures, `report.html` and `metrics.json` to `folder`.
pub(crate) fn write(
    folder: &Path,
    law: &str,
    found: &[Found],
    summary: &Summary,
    png: bool,
    context: &Context,
) -> anyhow::Result<()> {
    let about = format!(
        "Load scale, friction by the law {law} at speeds that were recorded, and backlash of {} servos.",
        found.len()
    );
    let mut page = page(folder, "Identified servos", summary, &about, context)?;
    for servo in found {
        page.heading(&format!("Servo {}", servo.number));
        match &servo.pulley {
            Ok(pulley) => page.list([
                ("Samples of steady motion", pulley.samples.len().to_string()),
                ("Misfit of the law, 1 for none [-]", format!("{:.2}", pulley.misfit)),
            ]),
            Err(bad) => page.paragraph(&format!("Friction cannot be told: {bad}")),
        }
        page.table(&["Number", "Value", "Standard error", ""], servo.rows.iter().map(|row| row.cells()));
    }
    page.heading("Figures");
    let servos: Vec<JointSeries> = found.iter().filter_map(series).collect();
    for chart in [friction_curves(&servos), errors_over_speed(&servos)] {
        page.figure(&save(folder, &chart, png)?);
    }
    for chart in errors_over_time(&servos) {
        page.figure(&save(folder, &chart, png)?);
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
        page.figure(&save(folder, &chart, png)?);
    }
    finish(folder, page, summary)
}

fn series(servo: &Found) -> Option<JointSeries> {
    let pulley = servo.pulley.as_ref().ok()?;
    let measured: Vec<f64> = pulley.friction.clone();
    let predicted = measured.iter().zip(&pulley.residuals).map(|(m, left)| m - left).collect();
    let velocity = pulley.samples.velocity.clone();
    let name = format!("servo {}", servo.number);
    Some(JointSeries::new(name, [velocity, measured, predicted], &|v| servo.friction(v)))
}

fn reversals(servo: &Found) -> Option<Scatter> {
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
