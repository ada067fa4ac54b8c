//! The report of a run.

use hysteron_control::score::AxisScore;
use hysteron_report::folder::ReportFolder;
use hysteron_report::page::Page;

use super::figures;
use super::outcome::{Outcome, Run};
use crate::shared::shapes::{NamedShape, TipShapes};

/// Writes all figures of a run, `report.html` and `metrics.json` to `folder`.
pub(super) fn write(
    folder: &ReportFolder,
    run: &Run,
    outcome: &Outcome,
    shapes: Option<&TipShapes>,
) -> anyhow::Result<()> {
    let title = format!("{}: {}", outcome.robot.name, run.task.title());
    let mut page = Page::concluded(&title, &conclusion(outcome), &outcome.source, &outcome.command);
    results(&mut page, outcome);
    if !outcome.shapes.is_empty() {
        page.table(&NamedShape::HEADINGS, outcome.shapes.iter().map(NamedShape::cells));
    }
    page.heading("Figures");
    for chart in figures::tip_and_error(run)? {
        folder.add(&mut page, &chart)?;
    }
    folder.add(&mut page, &figures::tip_path(run)?)?;
    for chart in figures::tendons(run) {
        folder.add(&mut page, &chart)?;
    }
    if let Some(shapes) = shapes {
        folder.add(&mut page, &shapes.figure())?;
    }
    folder.add(&mut page, &figures::robot(run))?;
    model(&mut page, outcome);
    folder.write_metrics(outcome)?;
    folder.write_page(page, &outcome.commit)
}

fn mm(value: f64) -> String {
    format!("{:.2}", 1e3 * value)
}

/// Size of the model, and how it was solved.
fn model(page: &mut Page, outcome: &Outcome) {
    page.heading("Model and solver");
    page.list([
        ("Mesh", format!("{} nodes, {} tetrahedra", outcome.robot.nodes, outcome.robot.tetrahedra)),
        ("Degrees of freedom", outcome.robot.unknowns.to_string()),
        ("Auxiliary tendons", outcome.robot.auxiliary_tendons.to_string()),
        ("Computing time [s]", format!("{:.2}", outcome.run.wall_s)),
    ]);
    if let Some(chain) = &outcome.robot.chain {
        let size = format!("a chain of {} sections, {} degrees of freedom", chain.sections, chain.unknowns);
        page.list([("Moved, in place of the mesh, by", size)]);
    }
    page.details_list("Solver details", solver(outcome));
    page.small(&format!("Scene {}.", outcome.robot.scene_sha256));
}

/// The result of a run in a sentence.
fn conclusion(outcome: &Outcome) -> String {
    let run = &outcome.run;
    if let Some(score) = &run.against_measured {
        let [rms, most] = [score.rmse_m, score.max_m].map(|m| 1e3 * m);
        return format!(
            "The simulated tip is {rms:.2} mm off the measured one (RMSE), and at most {most:.2} mm."
        );
    }
    if let Some(goals) = &run.goals {
        return format!("{} of {} goals are out of reach.", goals.out_of_reach, run.samples);
    }
    let [x, y, z] = [0, 1, 2].map(|c| 1e3 * (run.tip_max_m[c] - run.tip_min_m[c]));
    format!("In {:.2} s the tip moved over {x:.2} x {y:.2} x {z:.2} mm.", run.duration_s)
}

/// Results of a run.
fn results(page: &mut Page, outcome: &Outcome) {
    let run = &outcome.run;
    page.heading("Results");
    if let Some(score) = &run.against_measured {
        let percent =
            |nrmse: Option<f64>| nrmse.map_or("-".to_owned(), |part| format!("{:.2}", 100.0 * part));
        let row = |(axis, score): (&str, &AxisScore)| {
            vec![axis.to_owned(), format!("{:.3}", 1e3 * score.rmse_m), percent(score.nrmse)]
        };
        let distance = vec!["distance".to_owned(), format!("{:.3}", 1e3 * score.rmse_m), "-".to_owned()];
        let rows = ["x", "y", "z"].into_iter().zip(&score.axes).map(row).chain([distance]);
        page.table(&["Simulated against measured tip", "RMSE [mm]", "NRMSE [%]"], rows);
        page.list([("Largest distance from the measured tip [mm]", format!("{:.3}", 1e3 * score.max_m))]);
    }
    if let Some(goals) = &run.goals {
        page.list([
            ("Goals out of reach", format!("{} of {}", goals.out_of_reach, run.samples)),
            ("Tolerance [mm]", (1e3 * goals.tolerance_m).to_string()),
            ("Largest distance from a goal [mm]", format!("{:.1e}", 1e3 * goals.largest_distance_m)),
        ]);
    }
    if let Some(band) = &run.tip_band {
        page.paragraph(&format!("{}.", band.sentence()));
    }
    if let Some(part) = run.extrapolated {
        page.list([("Network outside its training range", format!("{:.1} % of the samples", 100.0 * part))]);
    }
    if let Some(part) = run.outside_validation.filter(|part| *part > 0.0) {
        page.list([("Chain bent further than validated", format!("{:.1} % of the samples", 100.0 * part))]);
    }
    if let Some(exact) = &run.exact {
        let range = |[median, largest]: [f64; 2]| format!("{median:.4} (median), {largest:.4} at most");
        page.list([
            ("Samples made by the finite elements too", exact.samples.to_string()),
            ("Distance of the tips [mm]", range([exact.tip_median_m, exact.tip_largest_m].map(|m| 1e3 * m))),
            ("Error of a tension [N]", range([exact.tension_median_n, exact.tension_largest_n])),
            ("Of these without an equilibrium", exact.unsolved.to_string()),
        ]);
    }
    let range = |c: usize| format!("{} to {}", mm(run.tip_min_m[c]), mm(run.tip_max_m[c]));
    page.list([
        ("Samples", run.samples.to_string()),
        ("Duration [s]", format!("{:.2}", run.duration_s)),
        ("Tip x [mm]", range(0)),
        ("Tip y [mm]", range(1)),
        ("Tip z [mm]", range(2)),
    ]);
    if !run.tendons.is_empty() {
        let headings = ["Tendon", "Stroke [mm]", "Largest tension [N]", "At the lower tension bound"];
        let rows = run.tendons.iter().map(|tendon| {
            vec![
                tendon.name.clone(),
                format!("{} to {}", mm(tendon.stroke_min_m), mm(tendon.stroke_max_m)),
                format!("{:.2}", tendon.tension_max_n),
                format!("{:.1} % of the time", 100.0 * tendon.share_at_lower_bound),
            ]
        });
        page.table(&headings, rows);
    }
}

/// How a run was computed.
fn solver(outcome: &Outcome) -> Vec<(&'static str, String)> {
    let run = &outcome.run;
    let mut rows = vec![
        ("Steps", run.steps.to_string()),
        ("Steps per second", format!("{:.0}", outcome.steps_per_s)),
        ("Iterations per step", format!("{:.2}", outcome.iterations_per_step)),
        ("Refactorisations of the stiffness", run.refactorisations.to_string()),
        ("Newton iterations", run.newton_iterations.to_string()),
        ("Substeps", run.sub_steps.to_string()),
        ("QPs solved by Clarabel", run.clarabel_solves.to_string()),
        ("Largest relative force residual", format!("{:.1e}", run.worst_relative_residual)),
        ("Largest stroke residual [mm]", format!("{:.1e}", 1e3 * run.worst_stroke_error_m)),
    ];
    if run.goals.is_some() {
        rows.push(("QPs solved for strokes", run.rounds.to_string()));
    }
    rows
}
