//! The page of `arm simulate`: joints, torques and what they are spent on, energies, and the arm at several times.

use hysteron_arm_dynamics::{JointKind, Model};
use hysteron_arm_estimation::{DynamicsOutput, JointQuantityKind, channel_name, dynamics_of_rows};
use hysteron_base::{Metadata, Recording};
use hysteron_report::folder::ReportFolder;
use hysteron_report::lines::{Curve, TimeChart, TimePanel};
use hysteron_report::page::Page;
use hysteron_report::sheet::number;

use super::outcome::{JointMotionRange, Outcome, total_energy};
use crate::arm::motion_charts::{arm_at_several_times, joints_over_time};

/// Caption of the joints over time.
const JOINTS: &str = "Coordinate and speed of every joint over time [s]; each panel has its own scale.";

/// Writes the figures, `report.html` and `metrics.json` of `motion` to `folder`.
pub(super) fn write(
    folder: &ReportFolder,
    model: &Model,
    motion: &Recording,
    outcome: &Outcome,
) -> anyhow::Result<()> {
    folder.write_metrics(outcome)?;
    let Outcome { samples, duration_s, joints: ends, energy_j, .. } = outcome;
    let title = format!("Motion of {}", model.name());
    let conclusion = format!(
        "In {duration_s:.2} s the energy of the arm went from {:.3} to {:.3} J.",
        energy_j[0], energy_j[1]
    );
    let mut page = Page::concluded(&title, &conclusion, &motion.meta().source, &outcome.command);
    page.heading("Results");
    page.list([
        ("Duration [s]", format!("{duration_s:.3}")),
        ("Samples", samples.to_string()),
        ("Energy at the start and at the end [J]", format!("{:.4}, {:.4}", energy_j[0], energy_j[1])),
    ]);
    let cells =
        |row: &JointMotionRange| [row.name.clone(), number(row.least), number(row.most), number(row.fastest)];
    let head = ["Joint", "Least [rad or m]", "Most", "Fastest [1/s]"];
    page.table(&head, ends.iter().map(|row| cells(row).to_vec()));
    page.heading("Figures");
    folder.add(&mut page, &arm_at_several_times(model, motion)?)?;
    for chart in [
        joints_over_time(model, motion, &[JointQuantityKind::Position, JointQuantityKind::Velocity], JOINTS)?,
        torques(model, motion)?,
        energies(motion, total_energy(motion)?)?,
    ] {
        folder.add(&mut page, &chart)?;
    }
    folder.write_page(page, &outcome.commit)
}

fn torques(model: &Model, motion: &Recording) -> anyhow::Result<TimeChart> {
    let parts = dynamics_of_rows(
        model,
        motion,
        DynamicsOutput { frame: 0, derivatives: false },
        Metadata::default(),
    )?;
    let panel = |(k, joint): (usize, &hysteron_arm_dynamics::Joint)| {
        let unit = if joint.kind == JointKind::Revolute { ["n_m", "N m"] } else { ["n", "N"] };
        let applied = motion.require(&channel_name(model, JointQuantityKind::Torque, k))?;
        let of = |stem: &str| parts.require(&format!("{stem}_{}_{}", k + 1, unit[0]));
        let (gravity, coriolis) = (of("gravity")?, of("coriolis")?);
        let rest = (0..applied.len()).map(|i| applied[i] - gravity[i] - coriolis[i]).collect();
        let curves = vec![
            Curve::new("applied", 0, applied.to_vec()),
            Curve::new("gravity", 1, gravity.to_vec()),
            Curve::new("Coriolis", 2, coriolis.to_vec()),
            Curve::new("inertia, friction, stops", 3, rest),
        ];
        Ok(TimePanel::new(format!("{} [{}]", joint.name, unit[1]), curves))
    };
    let panels = model.joints().iter().enumerate().map(panel).collect::<anyhow::Result<_>>()?;
    let caption = "Torque of every joint and its parts over time [s]: against gravity, against Coriolis \
                   and centrifugal torques, and what is left, which accelerates the arm or goes into friction and stops.";
    Ok(TimeChart::over_time("torques", "Torques", caption, motion.time(), panels))
}

fn energies(motion: &Recording, total: Vec<f64>) -> anyhow::Result<TimeChart> {
    let curves = vec![
        Curve::new("kinetic", 0, motion.require("kinetic_energy_j")?.to_vec()),
        Curve::new("potential", 1, motion.require("potential_energy_j")?.to_vec()),
        Curve::new("sum", 2, total),
    ];
    let caption = "Energy of the arm [J] over time [s]; potential energy is zero in the height of the base.";
    let panels = vec![TimePanel::new("energy [J]", curves)];
    Ok(TimeChart::over_time("energies", "Energies", caption, motion.time(), panels))
}
