//! The page of `arm excite`: joints, torques next to their limits, and the arm at several times.

use hysteron_arm_dynamics::{Joint, JointKind, Model};
use hysteron_arm_estimation::{DynamicsOutput, JointQuantityKind, channel_name, dynamics_of_rows};
use hysteron_base::{Metadata, Recording};
use hysteron_report::folder::ReportFolder;
use hysteron_report::lines::{Curve, TimeChart, TimePanel};
use hysteron_report::page::Page;

use super::Outcome;
use crate::arm::motion_charts::{arm_at_several_times, joints_over_time};

/// Quantities of the joints over time, and their caption.
const JOINTS: ([JointQuantityKind; 3], &str) = (
    [JointQuantityKind::Position, JointQuantityKind::Velocity, JointQuantityKind::Acceleration],
    "Coordinate, speed and acceleration of every joint over time [s]; each panel has its own scale.",
);

/// Writes the figures, `report.html` and `metrics.json` of the motion `states` to `folder`.
pub(super) fn write(
    folder: &ReportFolder,
    (model, states): (&Model, &Recording),
    outcome: &Outcome,
) -> anyhow::Result<()> {
    folder.write_metrics(outcome)?;
    let Outcome { base_parameters, condition_number, condition_number_before, .. } = outcome;
    let title = format!("Designed motion of {}", outcome.robot);
    let conclusion = match condition_number {
        Some(number) => format!("The motion shows the parameters with a condition number of {number:.1}."),
        None => format!("A motion of {:.2} s from rest to rest.", outcome.duration_s),
    };
    let mut page = Page::concluded(&title, &conclusion, &states.meta().source, &outcome.command);
    page.heading("Results");
    let mut rows = vec![
        ("Duration [s]", format!("{:.3}", outcome.duration_s)),
        ("Samples", outcome.samples.to_string()),
    ];
    if let (Some(parameters), Some(condition), Some(before)) =
        (base_parameters, condition_number, condition_number_before)
    {
        rows.push(("Parameters that torques can identify", parameters.to_string()));
        rows.push(("Condition number of their regressor", format!("{condition:.1}")));
        rows.push(("The same of a drawn series within the limits", format!("{before:.1}")));
    }
    page.list(rows);
    page.heading("Figures");
    folder.add(&mut page, &arm_at_several_times(model, states)?)?;
    let (quantities, caption) = &JOINTS;
    for chart in [joints_over_time(model, states, quantities, caption)?, torques(model, states)?] {
        folder.add(&mut page, &chart)?;
    }
    folder.write_page(page, &outcome.commit)
}

/// A limit above so many times the largest torque is named and not drawn: next to it the torque would be a flat line.
const LIMIT_DRAWN: f64 = 4.0;

fn torques(model: &Model, states: &Recording) -> anyhow::Result<TimeChart> {
    let dynamics = dynamics_of_rows(
        model,
        states,
        DynamicsOutput { frame: 0, derivatives: false },
        Metadata::default(),
    )?;
    let panel = |(k, joint): (usize, &Joint)| {
        let of = |quantity| dynamics.require(&channel_name(model, quantity, k));
        let (tau, dq, drive) =
            (of(JointQuantityKind::Torque)?, of(JointQuantityKind::Velocity)?, &joint.drive);
        // `signum` of zero is one: at rest there is no friction.
        let sign = |v: f64| if v == 0.0 { 0.0 } else { v.signum() };
        let whole = tau.iter().zip(dq).map(|(t, v)| t + drive.dry_friction * sign(*v));
        let whole: Vec<f64> = whole.collect();
        let peak = whole.iter().fold(0.0_f64, |peak, tau| peak.max(tau.abs()));
        let mut curves = vec![Curve::new("torque", 0, whole)];
        let unit = if joint.kind == JointKind::Revolute { "N m" } else { "N" };
        let mut title = format!("{} [{unit}]", joint.name);
        match drive.effort_limit {
            Some(limit) if limit > LIMIT_DRAWN * peak => {
                title += &format!(", limit ±{}", hysteron_base::number::shown(limit));
            }
            Some(limit) => curves.extend([
                Curve::new("upper limit", 3, vec![limit; tau.len()]),
                Curve::new("lower limit", 4, vec![-limit; tau.len()]),
            ]),
            None => {}
        }
        Ok(TimePanel::new(title, curves))
    };
    let panels = model.joints().iter().enumerate().map(panel).collect::<anyhow::Result<_>>()?;
    let caption = "What every joint has to be driven with over time [s], friction of the robot's file included, and its limit.";
    Ok(TimeChart::over_time("torques", "Torques", caption, states.time(), panels))
}
