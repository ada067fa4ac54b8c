//! The page of `study wrist`.

use std::path::Path;

use hysteron_report::figure::{register_embedded_font, save};
use hysteron_report::lines::TimeChart;
use hysteron_report::page::{Page, write_metrics, write_page};

use super::cells::{DRIFTS, WristStudy};
use super::outcome::{Outcome, means};
use crate::arm::estimation::page::{joints, ours_and_published};
use crate::arm::estimation::simulated_errors::ErrorComparison;
use crate::arm::estimation::wrist::{Load, METHODS, WristCell, published};
use crate::arm::estimation::wrist_sweep::{SweepCell, TORQUES};

/// Writes `report.html` and `metrics.json`.
pub(super) fn write(folder: &Path, study: &WristStudy, outcome: &Outcome) -> anyhow::Result<()> {
    register_embedded_font()?;
    write_metrics(folder, outcome)?;
    let title = "Interaction torques of a wrist exoskeleton";
    let mut page = Page::with_verdict(title, &outcome.verdict, "study of external torques", &outcome.command);
    page.paragraph(
        "Simulated: table 3, column C of Saadatzi et al. (2019), made feasible, with bristles as friction, encoders of 30 000 steps a turn \
         and a torque constant 1 % too large. The estimators identify themselves from the paper's swept sine at nominal friction. \
         Published values are in brackets; the paper has no row beyond the fifth.",
    );
    for load in [Load::Payload, Load::ForceSensor] {
        for drift in DRIFTS {
            let cells: Vec<&WristCell> =
                study.cells.iter().filter(|cell| cell.load == load && cell.drift == drift).collect();
            table(&mut page, load, drift, &cells);
        }
    }
    sweep(folder, &mut page, &study.sweep)?;
    page.heading("Estimates");
    for load in [Load::Payload, Load::ForceSensor] {
        for (part, methods) in [("a", &METHODS[1..3]), ("b", &METHODS[3..6])] {
            let Some(cell) = study.cells.iter().find(|cell| cell.load == load && cell.drift == 0.0) else {
                continue;
            };
            page.figure(&save(folder, &estimates(cell, part, methods), false)?);
        }
    }
    let captions = [
        ("noise", "Noise on the encoders (figure 7)", "N m"),
        ("model-error", "A wrong model (figure 8)", "N m"),
        ("sensitivity", "Sensitivity to the mass of the second link (figure 9)", "m²/s²"),
    ];
    for (comparison, (name, title, unit)) in study.simulated.iter().zip(captions) {
        page.figure(&save(folder, &compared(comparison, [name, title, unit]), false)?);
    }
    write_page(folder, page.finish(&outcome.commit))
}

/// Figures 5 and 6.
fn sweep(folder: &Path, page: &mut Page, sweep: &SweepCell) -> anyhow::Result<()> {
    page.heading("Identification from the swept sine");
    let head = ["Model", "Joint 1: RMS [N m]", "Joint 2: RMS [N m]"];
    let published = [[0.2336, 0.1076], [0.0688, 0.0550], [0.0760, 0.0333]];
    let rows = TORQUES[1..].iter().zip(&sweep.rms_n_m).zip(published).map(|((name, rms), known)| {
        vec![
            (*name).to_owned(),
            ours_and_published(rms[0], known[0], 4),
            ours_and_published(rms[1], known[1], 4),
        ]
    });
    page.table(&head, rows);
    page.paragraph(
        "The paper's first two rows have its original friction model, ours have none. A constant torque and weight can hardly be distinguished \
         in a sweep of a third of a radian: what one of them has too much in figure 5 the other has too little.",
    );
    let shown = |values: &[Option<f64>]| values.iter().map(|x| x.unwrap_or(f64::NAN)).collect::<Vec<f64>>();
    let curves = [
        ("recorded torque less that of the bodies".to_owned(), [0, 1].map(|j| shown(&sweep.measured_n_m[j]))),
        ("identified".to_owned(), sweep.identified_n_m.clone()),
        ("true, in steady motion".to_owned(), sweep.true_n_m.clone()),
    ];
    let caption = "Torque over speed; recorded: means over bins of 0.05 rad/s.";
    let mut chart = joints("friction", ["Friction (figure 5)", caption, "N m"], &sweep.speed_rad_s, &curves);
    chart.x_name = "speed [rad/s]";
    page.figure(&save(folder, &chart, false)?);
    let curves: Vec<_> =
        TORQUES.iter().zip(&sweep.torque).map(|(name, rows)| ((*name).to_owned(), rows.clone())).collect();
    let title = "Torques of the swept sine (figure 6)";
    page.figure(&save(
        folder,
        &joints("sweep", [title, "Over time [s].", "N m"], &sweep.time_s, &curves),
        false,
    )?);
    Ok(())
}

fn table(page: &mut Page, load: Load, drift: f64, cells: &[&WristCell]) {
    page.heading(&format!("Table 4: {}, friction {:+.0} %", load.name(), 100.0 * drift));
    let head = ["Method", "Joint 1 [N m]", "Joint 1 [%]", "Joint 2 [N m]", "Joint 2 [%]"];
    let row = |k: usize| {
        let [errors, percents] = means(cells, k);
        let known = published(load).get(k).copied();
        let cell = |ours: f64, known: Option<f64>, digits: usize| match known {
            Some(known) => ours_and_published(ours, known, digits),
            None => format!("{ours:.digits$}"),
        };
        let joint = |j: usize| {
            [
                cell(errors[j], known.map(|known| known[0][j]), 3),
                cell(percents[j], known.map(|known| known[1][j]), 1),
            ]
        };
        [vec![METHODS[k].to_owned()], joint(0).to_vec(), joint(1).to_vec()].concat()
    };
    page.table(&head, (0..METHODS.len()).map(row));
}

fn estimates(cell: &WristCell, part: &str, methods: &[&str]) -> TimeChart {
    let of = |name: &&str| {
        let method = cell.methods.iter().find(|method| method.name == **name);
        ((*name).to_owned(), method.map_or([vec![], vec![]], |method| method.estimate.clone()))
    };
    let mut curves = vec![("true".to_owned(), cell.truth.clone())];
    curves.extend(methods.iter().map(of));
    let number = if cell.load == Load::Payload { 10 } else { 11 };
    let title = format!("Interaction torque, {} (figure {number}{part})", cell.load.name());
    let name = format!("{}-{part}", cell.load.name());
    joints(&name, [&title, "True and estimated torque over time [s].", "N m"], &cell.time_s, &curves)
}

fn compared(comparison: &ErrorComparison, [name, title, unit]: [&str; 3]) -> TimeChart {
    let pair = |rows: &[Vec<f64>]| [0, 1].map(|j| rows.get(j).cloned().unwrap_or_default());
    let mut curves = vec![
        ("inverse dynamics".to_owned(), pair(&comparison.inverse_dynamics)),
        ("disturbance observer".to_owned(), pair(&comparison.disturbance_observer)),
    ];
    if !comparison.truth.is_empty() {
        curves.push(("true".to_owned(), pair(&comparison.truth)));
    }
    joints(name, [title, "Over time [s].", unit], &comparison.time_s, &curves)
}
