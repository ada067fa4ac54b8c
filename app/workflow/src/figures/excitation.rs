//! The report of a designed motion: joints, torques next to their limits, and the arm at several times.

use std::path::Path;

use hysteron_arm::{Joint, JointKind, Model, Quantity, Wanted, channel_name, dynamics_of_rows};
use hysteron_base::{Metadata, Recording, json};

use super::arm::{ArmPicture, of_kind};
use hysteron_report::figure::{register_embedded_font, save};
use hysteron_report::lines::{Curve, TimeChart, TimePanel};
use hysteron_report::page::{Page, write_metrics, write_page};
use serde_json::Value;

/// Writes the figures, `report.html` and `metrics.json` of the motion `states` to `folder`.
pub fn write(folder: &Path, model: &Model, states: &Recording, with_png: bool) -> anyhow::Result<Value> {
    register_embedded_font()?;
    let meta = states.meta();
    let metrics = metrics(model, states);
    let value = write_metrics(folder, &metrics)?;
    let Metrics { samples, duration_s, base_parameters, condition_number, condition_number_before, .. } =
        metrics;
    let mut page = Page::new(&format!("Designed motion of {}", model.name()), &meta.source, &meta.command);
    page.heading("Results");
    let mut rows = vec![("Duration [s]", format!("{duration_s:.3}")), ("Samples", samples.to_string())];
    if let (Some(parameters), Some(condition), Some(before)) =
        (base_parameters, condition_number, condition_number_before)
    {
        rows.push(("Parameters that torques can tell apart", format!("{parameters}")));
        rows.push(("Condition number of their regressor", format!("{condition:.1}")));
        rows.push(("The same of a drawn series within the limits", format!("{before:.1}")));
    }
    page.list(rows);
    page.heading("Figures");
    page.figure(&save(folder, &ArmPicture::new(model, states)?, with_png)?);
    for chart in [joints(model, states)?, torques(model, states)?] {
        page.figure(&save(folder, &chart, with_png)?);
    }
    write_page(folder, page.finish(&meta.commit))?;
    Ok(value)
}

/// The summary, where no report is asked for.
pub fn summarise(model: &Model, states: &Recording) -> anyhow::Result<Value> {
    Ok(json::to_value(metrics(model, states))?)
}

/// Every number of the report; those of a search only where there was one.
#[derive(serde::Serialize)]
struct Metrics<'a> {
    format: &'static str,
    version: u32,
    robot: &'a str,
    samples: usize,
    duration_s: f64,
    base_parameters: Option<f64>,
    condition_number: Option<f64>,
    condition_number_before: Option<f64>,
    seed: Option<u64>,
    command: &'a str,
    commit: &'a str,
}

fn metrics<'a>(model: &'a Model, states: &'a Recording) -> Metrics<'a> {
    let (meta, time) = (states.meta(), states.time());
    let number = |key: &str| meta.extra.get(key).and_then(|text| text.parse::<f64>().ok());
    Metrics {
        format: "hysteron-metrics",
        version: 1,
        robot: model.name(),
        samples: time.len(),
        duration_s: time[time.len() - 1] - time[0],
        base_parameters: number("base_parameters"),
        condition_number: number("condition_number"),
        condition_number_before: number("condition_number_before"),
        seed: meta.seed,
        command: &meta.command,
        commit: &meta.commit,
    }
}

fn joints(model: &Model, states: &Recording) -> anyhow::Result<TimeChart> {
    let mut panels = Vec::new();
    for (kind, unit) in [(JointKind::Revolute, "rad"), (JointKind::Prismatic, "m")] {
        for (quantity, label) in [
            (Quantity::Position, format!("q [{unit}]")),
            (Quantity::Velocity, format!("q' [{unit}/s]")),
            (Quantity::Acceleration, format!("q'' [{unit}/s²]")),
        ] {
            let curve = |(i, (k, name)): (usize, (usize, &str))| {
                Ok(Curve::new(name, i, states.require(&channel_name(model, quantity, k))?.to_vec()))
            };
            let curves = of_kind(model, kind).into_iter().enumerate().map(curve);
            panels.push(TimePanel::new(label, curves.collect::<anyhow::Result<_>>()?));
        }
    }
    panels.retain(|panel| !panel.curves.is_empty());
    let caption =
        "Coordinate, speed and acceleration of every joint over time [s]; each panel has its own scale.";
    Ok(TimeChart::over_time("joints", "Joints", caption, states.time(), panels))
}

fn torques(model: &Model, states: &Recording) -> anyhow::Result<TimeChart> {
    let dynamics =
        dynamics_of_rows(model, states, Wanted { frame: 0, derivatives: false }, Metadata::default())?;
    let panel = |(k, joint): (usize, &Joint)| {
        let of = |quantity| dynamics.require(&channel_name(model, quantity, k));
        let (tau, dq, drive) = (of(Quantity::Torque)?, of(Quantity::Velocity)?, &joint.drive);
        // `signum` of zero is one: at rest there is no friction.
        let sign = |v: f64| if v == 0.0 { 0.0 } else { v.signum() };
        let whole = tau.iter().zip(dq).map(|(t, v)| t + drive.dry_friction * sign(*v));
        let mut curves = vec![Curve::new("torque", 0, whole.collect())];
        for (name, sign) in [("limit", 1.0), ("limit, backwards", -1.0)] {
            let limit = drive.effort_limit.map(|most| Curve::new(name, 3, vec![sign * most; tau.len()]));
            curves.extend(limit);
        }
        let unit = if joint.kind == JointKind::Revolute { "N m" } else { "N" };
        Ok(TimePanel::new(format!("{} [{unit}]", joint.name), curves))
    };
    let panels = model.joints().iter().enumerate().map(panel).collect::<anyhow::Result<_>>()?;
    let caption = "What every joint has to be driven with over time [s], friction of the robot's file included, and its limit.";
    Ok(TimeChart::over_time("torques", "Torques", caption, states.time(), panels))
}
