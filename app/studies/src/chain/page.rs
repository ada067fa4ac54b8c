//! The page of `study run`: stages and results, explained for a first reader.

use std::path::Path;

use hysteron_base::Recording;
use hysteron_control::score::PathScore;
use hysteron_report::figure::{Drawn, register_embedded_font, save};
use hysteron_report::hysteresis_loop::{HysteresisLoop, StrokePath};
use hysteron_report::lines::TimeChart;
use hysteron_report::page::{Page, write_metrics, write_page};
use hysteron_report::series::{MEASURED, TWIN, TipSeries, UNCORRECTED, error_panel, tip_panels};
use hysteron_workflow::tendon::evaluate::{self, Row};

use super::definition::{Study, Track};
use super::outcome::{Outcome, PredictedPath, Tracked, read_predicted};
use super::stage::Stage;
use super::text;

/// Writes the figures, `report.html` and `metrics.json` to the folder of the study.
pub(super) fn write(
    out: &Path,
    study: &Study,
    stages: &[Stage],
    (outcome, rows): (&Outcome, &[Vec<Row>]),
) -> anyhow::Result<()> {
    register_embedded_font()?;
    write_metrics(out, outcome)?;
    let title = format!("Study {}", study.name);
    let mut page = Page::with_verdict(&title, &outcome.verdict, text::ABOUT, &outcome.command);
    page.paragraph(&text::rig(study));
    if let Some(track) = &study.track {
        text::outcome(&mut page, track, &outcome.tracked);
    }
    page.heading("Stages");
    page.table(&["Stage", "What it does"], text::stages(stages));
    if study.has_residual() {
        show_twin(&mut page, out, study, &outcome.predicted)?;
    }
    if let Some(track) = &study.track {
        show_tracking(&mut page, out, track, (&outcome.tracked, rows))?;
    }
    text::files(&mut page, stages, out);
    write_page(out, page.finish(&outcome.commit))
}

/// The tip of the measured and of the two simulated recordings of a trajectory, along the direction of the first
/// tendon [rad], over that tendon's stroke. `None` where one has no tip.
fn hysteresis(
    trajectory: &str,
    direction: f64,
    measured: &Recording,
    simulated: [&Recording; 2],
) -> Option<HysteresisLoop> {
    let stroke = *measured.strokes().first()?;
    let path = |recording: &Recording| {
        let [x, y, _] = recording.tip()?;
        let along = x.iter().zip(y).map(|(x, y)| 1e3 * (x * direction.cos() + y * direction.sin()));
        Some(stroke.iter().map(|stroke| 1e3 * stroke).zip(along).collect::<StrokePath>())
    };
    let [without, with] = simulated.map(path);
    Some(HysteresisLoop {
        trajectory: trajectory.to_owned(),
        robot: path(measured)?,
        twin: [without?, with?],
    })
}

fn show_twin(page: &mut Page, out: &Path, study: &Study, predicted: &[PredictedPath]) -> anyhow::Result<()> {
    let Some(first) = predicted.first() else { return Ok(()) };
    page.heading("Hysteresis of the twin");
    page.paragraph(text::TWIN);
    let (measured, simulated) = read_predicted(out, &first.trajectory)?;
    let [without, with] = &simulated;
    let simulated = [without, with];
    if let Some(figure) = hysteresis(&first.trajectory, study.rig.first_angle, &measured, simulated) {
        page.figure(&save(&out.join("figures"), &figure, false)?);
    }
    if let Some(charts) = over_time(&first.trajectory, &measured, [without, with]) {
        for chart in charts {
            page.figure(&save(&out.join("figures"), &chart, false)?);
        }
    }
    let percent = |score: &PathScore| -> String {
        let part =
            |c: usize| score.axes[c].nrmse.map_or("-".to_owned(), |part| format!("{:.1}", 100.0 * part));
        format!("{}, {}", part(0), part(1))
    };
    let row = |it: &PredictedPath| {
        let mm = |score: &PathScore| format!("{:.2}", 1e3 * score.rmse_m);
        vec![it.trajectory.clone(), mm(&it.without), mm(&it.with), percent(&it.without), percent(&it.with)]
    };
    let headings = [
        "Test path",
        "RMSE [mm] without network",
        "with network",
        "NRMSE of x, y [%] without network",
        "with network",
    ];
    page.table(&headings, predicted.iter().map(row));
    Ok(())
}

/// Tip and error of a trajectory over time, measured and of the twin without its network and with it.
fn over_time(trajectory: &str, measured: &Recording, twins: [&Recording; 2]) -> Option<[TimeChart; 2]> {
    let gap = measured.gap();
    let robot = TipSeries::new("measured", MEASURED, &measured.tip()?).without_gaps(gap);
    let twin = |name, color, recording: &Recording| Some(TipSeries::new(name, color, &recording.tip()?));
    let twins = [
        twin("twin without the network", UNCORRECTED, twins[0])?,
        twin("twin with the network", TWIN, twins[1])?,
    ];
    let errors = TimeChart::over_time(
        "predicted-error",
        format!("{trajectory}: error of the twin's tip"),
        "Distance of the twin's tip from the measured one [mm] over time [s], without and with the network.",
        measured.time(),
        vec![error_panel(&robot, &twins)],
    );
    let [without, with] = twins;
    let tips = TimeChart::over_time(
        "predicted-tip",
        format!("{trajectory}: tip"),
        "Tip as measured, of the twin without and of the twin with the network [mm], over time [s]; each axis has its own \
         scale.",
        measured.time(),
        tip_panels(&[robot, without, with]),
    );
    Some([tips, errors])
}

fn show_tracking(
    page: &mut Page,
    out: &Path,
    track: &Track,
    (tracked, rows): (&[Tracked], &[Vec<Row>]),
) -> anyhow::Result<()> {
    page.heading("Tracking of test paths");
    page.paragraph(text::TRACKING);
    text::tracking_table(page, track, tracked);
    let n = track.methods.len();
    for ((target, methods), rows) in track.targets.iter().zip(tracked.chunks(n)).zip(rows.chunks(n)) {
        // The first repeat of each method, side by side.
        let first = |(it, rows): (&Tracked, &Vec<Row>)| {
            Some(Row { name: it.method.name().to_owned(), ..rows.first()?.clone() })
        };
        let rows: Vec<Row> = methods.iter().zip(rows).filter_map(first).collect();
        if !rows.is_empty() {
            let folder = out.join("figures").join(&target.name);
            let over_time = evaluate::over_time(&target.path, &rows);
            let over_time = over_time.map(|chart| save(&folder, &chart, false)).transpose()?;
            let overlay = save(&folder, &evaluate::overlay(&target.path, &rows), false)?;
            for drawn in [overlay].into_iter().chain(over_time) {
                page.figure(&Drawn { title: format!("{}: {}", target.path.name, drawn.title), ..drawn });
            }
        }
    }
    text::glossary(page);
    Ok(())
}
