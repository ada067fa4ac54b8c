//! The figures of a run.

use anyhow::Context as _;
use hysteron_report::body_views::{BodyViews, Rank, TensionLine};
use hysteron_report::lines::{Curve, PanelScale, TimeChart, TimePanel};
use hysteron_report::path_views::{PathViews, SpacePath};
use hysteron_report::series::{
    MEASURED, TARGET, TWIN, TipSeries, error_panel, millimetres, numbered_panels, tip_panels,
};
use hysteron_report::sheet::number;
use hysteron_report::strokes::auxiliary_strokes;
use hysteron_twin::TwinTendon;

use super::band::TIP_BAND;
use super::outcome::Run;

/// Colour of the band.
const BAND: usize = 3;

/// Strokes and tensions of a run over time.
pub(super) fn tendons(run: &Run) -> Vec<TimeChart> {
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
pub(super) fn tip_and_error(run: &Run) -> anyhow::Result<Vec<TimeChart>> {
    let rest = run.twin.tip_of(&run.twin.rest());
    let tip = run.recording.tip().context("the recording has no tip")?;
    let twin = TipSeries::new("simulated", TWIN, &tip).relative_to(rest);
    let measured = run
        .measured
        .map(|tip| TipSeries::new("measured", MEASURED, &tip).without_gaps(run.gap).relative_to(rest));
    let goals = run.goals.map(|goals| TipSeries::new("goal", TARGET, &goals.positions()).relative_to(rest));
    let band = run.summary.tip_band.as_ref().zip(run.recording.channel(TIP_BAND)).map(|(band, radius)| {
        let level = 100.0 * band.level;
        Curve { width: 2.0, ..Curve::new(format!("{level:.0} % expected within"), BAND, millimetres(radius)) }
    });
    let error = match (&measured, &goals) {
        (Some(measured), _) => {
            let mut panel = error_panel(measured, std::slice::from_ref(&twin));
            panel.curves.extend(band);
            let caption = "Distance of the simulated tip from the measured one over time [mm]; with a residual network the band \
                           that recordings left out in its training expect it in.";
            Some((caption, panel))
        }
        (None, Some(goals)) => Some((
            "Distance of the tip from its goal over time [mm].",
            error_panel(goals, std::slice::from_ref(&twin)),
        )),
        (None, None) => band.map(|band| {
            let caption = "Radius about the simulated tip within which recordings left out in the training of the network expect \
                           the robot's own [mm].";
            (caption, TimePanel::new("expected error [mm]", vec![band]))
        }),
    };
    let tips: Vec<TipSeries> = measured.into_iter().chain(goals).chain([twin]).collect();
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
    let panel = |((commanded, measured), tendon): ((&[f64], &[f64]), &TwinTendon)| {
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
    TimeChart { scale: PanelScale::Common, ..chart }
}

fn tensions(run: &Run) -> TimeChart {
    let tensions = run.recording.numbered("tension", "n").into_iter().take(run.twin.n_primary);
    let mut panels = numbered_panels("tension [N]", "tendon", tensions.map(<[f64]>::to_vec).collect());
    let curves = panels.iter_mut().flat_map(|panel| &mut panel.curves);
    curves.zip(&run.twin.tendons).for_each(|(curve, tendon)| curve.name.clone_from(&tendon.name));
    let caption = "Tension of every tendon [N]; zero is slack.";
    TimeChart::over_time("tensions", "Tension of every tendon", caption, run.recording.time(), panels)
}

/// The path of the tip from three sides, over its goals where it had any.
pub(super) fn tip_path(run: &Run) -> anyhow::Result<PathViews> {
    let tip = run.recording.tip().context("the recording has no tip")?;
    let time = run.recording.time();
    let path =
        |name: &str, axes: [&[f64]; 3]| SpacePath { name: name.to_owned(), axes: axes.map(millimetres) };
    let caption = "Path of the tip from above and from two sides [mm], coloured by time; the two axes of a view have one \
                   scale. Circle: first sample; triangle: last."
        .to_owned()
        + if run.goals.is_some() { " Blue dots below: the goals." } else { "" }
        + if run.measured.is_some() { " Wide grey line below: the tip as measured on the robot." } else { "" };
    Ok(PathViews {
        name: "tip-path".to_owned(),
        title: "Path of the tip".to_owned(),
        caption,
        path: path("simulated", tip),
        goals: run.goals.map(|goals| path("goals", goals.positions())),
        reference: run.measured.map(|measured| path("measured", measured)),
        time: [time[0], time[time.len() - 1]],
    })
}

/// The robot where its tip was farthest from rest, with its tendons.
pub(super) fn robot(run: &Run) -> BodyViews {
    let (row, state) = run.farthest;
    let nodes = run.twin.nodes_of(state);
    let mm = |points: &[[f64; 4]]| -> Vec<[f64; 3]> {
        points.iter().map(|[x, y, z, _]| [1e3 * x, 1e3 * y, 1e3 * z]).collect()
    };
    let tendon = |(j, tendon): (usize, &TwinTendon)| {
        let points = run.twin.cables.polyline(j, &nodes);
        TensionLine {
            name: tendon.name.clone(),
            rank: if j < run.twin.n_primary { Rank::Primary } else { Rank::Auxiliary },
            points: points.iter().map(|point| point.map(|c| 1e3 * c)).collect(),
            tension: state.tensions[j],
        }
    };
    let time = number(run.recording.time()[row.min(run.recording.n_samples() - 1)]);
    BodyViews {
        name: "robot".to_owned(),
        title: format!("{} at t = {time} s", run.scene.name),
        caption: format!(
            "The robot at t = {time} s, where its tip is farthest from rest, with its tendons coloured by tension [N]; a \
             thin grey tendon is slack. The pale outline is the unloaded body."
        ),
        faces: run.twin.body.cells.surface(),
        rest: mm(&run.twin.body.rest),
        moved: mm(&nodes),
        lines: run.twin.tendons.iter().enumerate().map(tendon).collect(),
    }
}
