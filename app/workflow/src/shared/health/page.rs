//! The section of a report on the health of a rig's servos.

use hysteron_actuator::health::{Health, Quantity, ServoHealth};
use hysteron_report::folder::ReportFolder;
use hysteron_report::lines::TimeChart;
use hysteron_report::page::Page;
use hysteron_report::series::numbered_panels;

use super::cells;

/// Adds table and figure to a page whose figures are in `folder`.
///
/// # Errors
/// Figures that cannot be drawn or written.
pub(crate) fn section(page: &mut Page, folder: &ReportFolder, health: &Health) -> anyhow::Result<()> {
    page.heading("Servos");
    page.paragraph(
        "Dry friction from loads of slack tendons, as a part of full load; lost motion of a pulley before the tip follows, by play and by \
         friction of the guides; temperature of the case. A dash: this motion does not determine it.",
    );
    match &health.baseline {
        Some(name) => page.paragraph(&format!(
            "Condition is the probability that neither friction nor lost motion is a quarter more than in {name}."
        )),
        None => page.paragraph("Without a baseline (--baseline) there is no condition."),
    }
    let headings = [
        "Servo",
        "Friction pulling [%]",
        "Friction releasing [%]",
        "Lost motion [mm]",
        "Highest temperature [degC]",
        "Largest change [%]",
        "Condition",
    ];
    page.table(&headings, health.servos.iter().map(cells));
    if health.time_s.len() > 1 {
        folder.add(page, &over_time(health))?;
    }
    Ok(())
}

fn over_time(health: &Health) -> TimeChart {
    let series = |of: &dyn Fn(&ServoHealth, usize) -> Option<f64>| -> Vec<Vec<f64>> {
        let windows = |servo| (0..health.time_s.len()).map(|w| of(servo, w).unwrap_or(f64::NAN)).collect();
        health.servos.iter().map(windows).collect()
    };
    let mut panels = Vec::new();
    for quantity in Quantity::ALL {
        let values = series(&|servo, w| servo.windows[w].get(quantity).map(|it| it.value));
        panels.extend(numbered_panels(quantity.label(), "servo", values));
    }
    let heat = series(&|servo, w| servo.windows[w].temperature_degc);
    panels.extend(numbered_panels("temperature [degC]", "servo", heat));
    let caption = "Friction, lost motion and temperature of the servos, minute by minute of recorded time [s]; pauses between recordings are not shown.";
    TimeChart::over_time("servo-health", "Servos over time", caption, &health.time_s, panels)
}
