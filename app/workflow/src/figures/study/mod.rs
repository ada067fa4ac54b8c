//! The report of a study: stages and results, in words for somebody who reads it for the first time.
//!
//! Everything in it comes from the files of the stages, and nothing from the clock: a study that was interrupted ends
//! with the same bytes.

mod hysteresis;
mod text;

use std::path::{Path, PathBuf};

use hysteron_base::Recording;
use hysteron_control::score::{PathScore, score};
use hysteron_control::tracking::{CurvePart, TipOrigin};
use serde::Serialize;
use serde_json::Value;

use super::tracking;
use crate::shared::inputs;
use crate::study::{DATA, Method, PREDICTED, STROKES, Stage, Study, Target, Track, folder, repeat};
use crate::tendon::evaluate::{self, Row};
use crate::{COMMIT, Context};
use hysteresis::Hysteresis;
use hysteron_report::figure::{Drawn, register_embedded_font, save};
use hysteron_report::lines::TimeChart;
use hysteron_report::page::{Page, write_metrics, write_page};
use hysteron_report::series::{MEASURED, TWIN, TipSeries, UNCORRECTED, error_panel, tip_panels};
use hysteron_report::verdict::{Criterion, Verdict};

use crate::shared::verdict::compared;

#[derive(Serialize)]
struct Metrics<'a> {
    format: &'static str,
    version: u32,
    /// Whether the trained controllers bring the robot along paths.
    verdict: Verdict,
    study: &'a str,
    robot: &'a str,
    rig: &'a str,
    is_virtual: bool,
    seed: u64,
    predicted: &'a [Predicted],
    tracked: &'a [Tracked<'a>],
    stages: Vec<StageLine<'a>>,
    command: &'a str,
    commit: &'a str,
}

#[derive(Serialize)]
struct StageLine<'a> {
    name: &'a str,
    commands: Vec<String>,
}

/// A trajectory that was not in the twin's training.
#[derive(Serialize)]
struct Predicted {
    trajectory: String,
    /// Of the twin without its network.
    without: PathScore,
    /// With it.
    with: PathScore,
}

/// A target by one method.
#[derive(Serialize)]
struct Tracked<'a> {
    target: &'a str,
    method: Method,
    /// One for each repeat; none where the rig did not carry the strokes out.
    rmse_m: Vec<f64>,
    nrmse: Vec<Option<f64>>,
    iou: Vec<Option<f64>>,
    aligned_rmse_m: Vec<Option<f64>>,
    lag_s: Vec<Option<f64>>,
    /// Part of the samples in which a limit reduced a stroke.
    held_back: f64,
    /// Part of the samples in which a network left its training range.
    extrapolating: f64,
    #[serde(skip)]
    rows: Vec<Row>,
}

impl Tracked<'_> {
    fn is_carried_out(&self) -> bool {
        !self.rows.is_empty()
    }
}

/// Writes the figures, `report.html` and `metrics.json` to the folder of the study.
pub fn write(out: &Path, study: &Study, stages: &[Stage], context: &Context) -> anyhow::Result<Value> {
    register_embedded_font()?;
    let predicted = predicted(out, study)?;
    let tracked = study.track.as_ref().map_or(Ok(Vec::new()), |track| tracked(out, track))?;
    let (command, commit) = (context.command.clone(), COMMIT);
    let line = |stage: &'_ Stage| stage.steps.iter().map(|step| step.shown()).collect();
    let lines = stages.iter().map(|stage| StageLine { name: &stage.name, commands: line(stage) });
    let metrics = Metrics {
        format: "hysteron-metrics",
        version: 1,
        verdict: judged(&predicted, &tracked),
        study: &study.name,
        robot: &study.scene.robot,
        rig: &study.rig.description,
        is_virtual: study.rig.is_virtual,
        seed: study.seed,
        predicted: &predicted,
        tracked: &tracked,
        stages: lines.collect(),
        command: &command,
        commit,
    };
    let value = write_metrics(out, &metrics)?;

    let mut page = Page::judged(&format!("Study {}", study.name), &metrics.verdict, text::ABOUT, &command);
    page.paragraph(&text::rig(study));
    if let Some(track) = &study.track {
        text::outcome(&mut page, track, &tracked);
    }
    page.heading("Stages");
    page.table(&["Stage", "What it does"], text::stages(stages));
    if study.has_residual() {
        show_twin(&mut page, out, study, &predicted)?;
    }
    if let Some(track) = &study.track {
        show_tracking(&mut page, out, track, &tracked)?;
    }
    text::files(&mut page, stages, out);
    write_page(out, page.finish(commit))?;
    Ok(value)
}

/// Whether the best method leads the tip along the targets, better than a nominal twin where there is one; without targets,
/// whether the network makes the twin better.
fn judged(predicted: &[Predicted], tracked: &[Tracked]) -> Verdict {
    let mean = |values: Vec<f64>| values.iter().sum::<f64>() / values.len() as f64;
    let mut methods: Vec<Method> = Vec::new();
    tracked.iter().for_each(|it| {
        if !methods.contains(&it.method) {
            methods.push(it.method)
        }
    });
    let of = |method: Method| tracked.iter().filter(move |it| it.method == method);
    let errors: Vec<(String, f64)> = methods
        .iter()
        .map(|&method| {
            (method.name().to_owned(), mean(of(method).flat_map(|it| it.rmse_m.clone()).collect()))
        })
        .filter(|(_, error)| error.is_finite())
        .map(|(name, error)| (name, 1e3 * error))
        .collect();
    let nrmse = |method: Method| mean(of(method).flat_map(|it| it.nrmse.iter().flatten().copied()).collect());
    let best = methods.iter().copied().min_by(|a, b| nrmse(*a).total_cmp(&nrmse(*b)));
    let rms = |of: fn(&Predicted) -> f64| mean(predicted.iter().map(of).collect());
    let network = (!predicted.is_empty()).then(|| rms(|it| it.with.rmse_m) / rms(|it| it.without.rmse_m));
    let mut judged = match best {
        Some(method) => Verdict::on(format!("the tip follows the targets by the method {}", method.name())),
        None => Verdict::on("the twin with its network foresees paths that it has not learned from"),
    };
    if let Some(method) = best {
        let (share, n) = (nrmse(method), of(method).count());
        let left = of(method).filter(|it| !it.is_carried_out()).count() as f64 / n.max(1) as f64;
        let outside = of(method).map(|it| it.extrapolating).fold(0.0, f64::max);
        judged = judged
            .because(
                Criterion::ErrorOverTarget,
                share,
                format!(
                    "the tip is off by {:.1} % of the targets' size (NRMSE) by {}",
                    100.0 * share,
                    method.name()
                ),
            )
            .because(
                Criterion::Missing,
                left,
                format!("{:.0} % of the targets were not carried out by {}", 100.0 * left, method.name()),
            )
            .because(
                Criterion::OutsideTraining,
                outside,
                format!("a network is outside its training in up to {:.0} % of the samples", 100.0 * outside),
            );
        judged = compared(judged, ("error of the tip", "mm"), &errors, Method::Nominal.name());
    }
    judged
        .because_of(Criterion::ErrorOverBaseline, network, |ratio| {
            format!("with its network the twin errs by {:.0} % of what it errs by without", 100.0 * ratio)
        })
        .verdict()
}

fn recording_of(out: &Path, trajectory: &str) -> PathBuf {
    out.join(DATA).join(format!("{trajectory}.parquet"))
}

/// A trajectory as measured, and by the twin without its network and with it.
fn read_predicted(out: &Path, trajectory: &str) -> anyhow::Result<(Recording, [Recording; 2])> {
    let simulated = |kind: &str| Recording::read(out.join(kind).join(trajectory).join("tip.parquet"));
    let [with, without] = PREDICTED.map(simulated);
    Ok((Recording::read(recording_of(out, trajectory))?, [without?, with?]))
}

fn predicted(out: &Path, study: &Study) -> anyhow::Result<Vec<Predicted>> {
    let checks = if study.has_residual() { &study.plan.checks[..] } else { &[] };
    let mut all = Vec::new();
    for (trajectory, _) in checks {
        let (measured, simulated) = read_predicted(out, trajectory)?;
        let whole: Vec<bool> = vec![false; measured.n_samples()];
        let gap = if measured.gap().is_empty() { &whole } else { measured.gap() };
        let [without, with] = simulated.each_ref().map(|it| Some(score(measured.tip()?, it.tip()?, gap)));
        if let (Some(without), Some(with)) = (without, with) {
            all.push(Predicted { trajectory: trajectory.clone(), without, with });
        }
    }
    Ok(all)
}

fn tracked<'a>(out: &Path, track: &'a Track) -> anyhow::Result<Vec<Tracked<'a>>> {
    let mut all = Vec::new();
    for target in &track.targets {
        for method in &track.methods {
            all.push(tracked_in(out, target, *method, track.repeats)?);
        }
    }
    Ok(all)
}

/// Results of one method on one target.
fn tracked_in<'a>(
    out: &Path,
    target: &'a Target,
    method: Method,
    repeats: usize,
) -> anyhow::Result<Tracked<'a>> {
    let folder = out.join(folder(target, method));
    let strokes = Recording::read(folder.join(STROKES))?;
    let part = |flag: &str| {
        strokes.channel(flag).map_or(0.0, |values| values.iter().sum::<f64>() / values.len() as f64)
    };
    let tips: Vec<PathBuf> = (1..=repeats).map(|k| folder.join(repeat(k))).collect();
    // A rig that refused one of them has not carried out the whole.
    let rows = if tips.iter().all(|tip| tip.exists()) {
        evaluate::rows(&target.path, inputs::read(&tips)?, CurvePart::AtTheSameTimes, TipOrigin::Frame)?
    } else {
        Vec::new()
    };
    Ok(Tracked {
        target: &target.path.name,
        method,
        rmse_m: rows.iter().map(|row| row.score.rmse_m).collect(),
        nrmse: rows.iter().map(|row| row.score.nrmse).collect(),
        iou: rows.iter().map(|row| row.score.iou).collect(),
        aligned_rmse_m: rows.iter().map(|row| row.score.aligned_rmse_m).collect(),
        lag_s: rows.iter().map(|row| row.score.lag_s).collect(),
        held_back: part("limited"),
        extrapolating: part("extrapolating"),
        rows,
    })
}

fn show_twin(page: &mut Page, out: &Path, study: &Study, predicted: &[Predicted]) -> anyhow::Result<()> {
    let Some(first) = predicted.first() else { return Ok(()) };
    page.heading("Hysteresis of the twin");
    page.paragraph(text::TWIN);
    let (measured, simulated) = read_predicted(out, &first.trajectory)?;
    let [without, with] = &simulated;
    if let Some(figure) =
        Hysteresis::new(&first.trajectory, study.rig.first_angle, &measured, [without, with])
    {
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
    let row = |it: &Predicted| {
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

fn show_tracking(page: &mut Page, out: &Path, track: &Track, tracked: &[Tracked]) -> anyhow::Result<()> {
    page.heading("Tracking of test paths");
    page.paragraph(text::TRACKING);
    text::tracking_table(page, track, tracked);
    for (target, methods) in track.targets.iter().zip(tracked.chunks(track.methods.len())) {
        // The first repeat of each method, side by side.
        let first = |it: &Tracked| {
            let row = it.rows.first()?;
            Some(Row { name: it.method.name().to_owned(), ..row.clone() })
        };
        let rows: Vec<Row> = methods.iter().filter_map(first).collect();
        if !rows.is_empty() {
            let folder = out.join("figures").join(&target.name);
            let over_time = tracking::over_time(&target.path, &rows);
            let over_time = over_time.map(|chart| save(&folder, &chart, false)).transpose()?;
            for drawn in [tracking::overlay(&folder, &target.path, &rows)?].into_iter().chain(over_time) {
                page.figure(&Drawn { title: format!("{}: {}", target.path.name, drawn.title), ..drawn });
            }
        }
    }
    text::glossary(page);
    Ok(())
}
