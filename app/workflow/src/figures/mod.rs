//! Figures and reports; the only folder that knows plotters.
//!
//! From the bottom up, each file knowing only those before it: `axis`, `sheet`, `simplify` (the look); `figure` (tiles,
//! files); `lines`, `series` (panels over time); `report` (pages); then a file for each kind of report.

pub mod arm;
pub mod arm_cloning;
pub mod arm_estimation;
pub mod arm_identification;
pub mod arm_neural;
pub mod arm_study;
pub mod commands;
pub mod coverage;
pub mod data_set;
pub mod excitation;
pub mod fit;
pub mod health;
pub mod identification;
pub mod identify_servo;
mod robot;
mod run_page;
pub mod sensing;
pub mod shapes;
pub mod study;
pub mod target;
mod tip;
pub mod tracking;
pub mod training;

use std::path::Path;

use anyhow::Context as _;

use crate::shared::run::{Outcome, Run, Task};
use hysteron_report::figure::{Drawn, register_embedded_font, save};
use hysteron_report::lines::{Curve, Scale, TimeChart, TimePanel};
use hysteron_report::series::{
    MEASURED, TARGET, TWIN, Tip, error_panel, millimetres, numbered_panels, tip_panels,
};
use robot::RobotPicture;
use shapes::CommandAndTip;
use tip::TipPath;

/// Writes all figures of a run, `report.html` and `metrics.json` to `folder`.
pub fn write(
    folder: &Path,
    run: &Run,
    (outcome, shape): (&Outcome, Option<&CommandAndTip>),
    with_png: bool,
) -> anyhow::Result<()> {
    register_embedded_font()?;
    let charts = tip_and_error(run)?;
    let mut drawn: Vec<Drawn> =
        charts.iter().map(|chart| save(folder, chart, with_png)).collect::<anyhow::Result<_>>()?;
    drawn.push(save(folder, &TipPath::new(run)?, with_png)?);
    for chart in tendons(run) {
        drawn.push(save(folder, &chart, with_png)?);
    }
    if let Some(figure) = shape {
        drawn.push(save(folder, figure, with_png)?);
    }
    drawn.push(save(folder, &RobotPicture::new(run), with_png)?);
    run_page::write(folder, run.task.title(), outcome, &drawn)
}

/// Command and tip of a run that followed strokes, where the tendons bend in two directions and something moved.
pub fn command_and_tip(run: &Run) -> Option<CommandAndTip> {
    let angles = crate::shared::plan::angles_of(run.scene);
    match run.task {
        Task::Simulate => CommandAndTip::new(&angles, &[(&run.scene.name, run.recording)]).ok(),
        Task::Reach(_) => None,
    }
}

/// Strokes and tensions of a run over time.
fn tendons(run: &Run) -> Vec<TimeChart> {
    let mut charts = Vec::new();
    if run.twin.n_primary > 0 {
        charts.extend([strokes(run), tensions(run)]);
    }
    let auxiliary: Vec<Vec<f64>> = run.recording.aux().into_iter().map(millimetres).collect();
    if !auxiliary.is_empty() {
        charts.push(auxiliary_strokes(run.recording.time(), auxiliary));
    }
    charts
}

/// Displacement of the tip, and its distance from the measured one or from the goals.
fn tip_and_error(run: &Run) -> anyhow::Result<Vec<TimeChart>> {
    let rest = run.twin.tip_of(&run.twin.rest());
    let tip = run.recording.tip().context("the recording has no tip")?;
    let twin = Tip::new("simulated", TWIN, &tip).relative_to(rest);
    let measured =
        run.measured.map(|tip| Tip::new("measured", MEASURED, &tip).without_gaps(run.gap).relative_to(rest));
    let goals = run.goals.map(|goals| Tip::new("goal", TARGET, &goals.positions()).relative_to(rest));
    let error = match (&measured, &goals) {
        (Some(measured), _) => Some((
            "Distance of the simulated tip from the measured one over time [mm].",
            error_panel(measured, std::slice::from_ref(&twin)),
        )),
        (None, Some(goals)) => Some((
            "Distance of the tip from its goal over time [mm].",
            error_panel(goals, std::slice::from_ref(&twin)),
        )),
        (None, None) => None,
    };
    let tips: Vec<Tip> = measured.into_iter().chain(goals).chain([twin]).collect();
    let time = run.recording.time();
    let mut charts = vec![TimeChart::over_time(
        "tip-time",
        "Displacement of the tip from rest",
        "Displacement of the tip from its position in the unloaded body [mm], over time [s]; each axis has its own scale.",
        time,
        tip_panels(&tips),
    )];
    charts.extend(error.map(|(caption, panel)| {
        TimeChart::over_time("tip-error", "Error of the tip", caption, time, vec![panel])
    }));
    Ok(charts)
}

/// Commanded and measured stroke, one panel per tendon.
fn strokes(run: &Run) -> TimeChart {
    let measured = run.recording.numbered("measured_stroke", "m");
    let panels = run.recording.strokes().into_iter().zip(measured).zip(&run.twin.tendons);
    let panel = |((commanded, measured), tendon): ((&[f64], &[f64]), &hysteron_twin::TendonSpec)| {
        // The measured one below: where the tendon is taut the two coincide.
        let curves = vec![
            Curve { width: 1.0, ..Curve::new("shortening along the body", 1, millimetres(measured)) },
            Curve { width: 1.4, ..Curve::new("commanded", 0, millimetres(commanded)) },
        ];
        TimePanel::new(format!("{} [mm]", tendon.name), curves)
    };
    let caption = "Stroke of every tendon [mm]: pulled length as commanded, and by how much the body has shortened along \
                   the tendon. They differ where a tendon is slack. All panels have one scale.";
    let panels = panels.map(panel).collect();
    let chart =
        TimeChart::over_time("strokes", "Stroke of every tendon", caption, run.recording.time(), panels);
    TimeChart { scale: Scale::Common, ..chart }
}

fn tensions(run: &Run) -> TimeChart {
    let tensions = run.recording.numbered("tension", "n").into_iter().take(run.twin.n_primary);
    let mut panels = numbered_panels("tension [N]", "tendon", tensions.map(<[f64]>::to_vec).collect());
    let curves = panels.iter_mut().flat_map(|panel| &mut panel.curves);
    curves.zip(&run.twin.tendons).for_each(|(curve, tendon)| curve.name.clone_from(&tendon.name));
    let caption = "Tension of every tendon [N]; zero is slack.";
    TimeChart::over_time("tensions", "Tension of every tendon", caption, run.recording.time(), panels)
}

/// Strokes of auxiliary tendons [mm].
fn auxiliary_strokes(time: &[f64], strokes: Vec<Vec<f64>>) -> TimeChart {
    let panels = numbered_panels("stroke [mm]", "auxiliary", strokes);
    let caption = "Strokes of the auxiliary tendons [mm], which correct the twin; zero is no correction. All panels have \
                   one scale.";
    let chart = TimeChart::over_time("auxiliary-strokes", "Auxiliary strokes", caption, time, panels);
    TimeChart { scale: Scale::Common, ..chart }
}
