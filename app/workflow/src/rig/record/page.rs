//! The page of `record`: what was commanded, what the tip made of it, and how the rig kept its time.

use hysteron_actuator::health::Health;
use hysteron_base::{Metadata, Recording};

use hysteron_report::folder::ReportFolder;
use hysteron_report::lines::{Shaded, TimeChart, spans, without_gaps};
use hysteron_report::page::Page;
use hysteron_report::series::{MEASURED, TipSeries, millimetres, numbered_panels, tip_panels};

use super::outcome::Outcome;
use super::summary::RecordedTrajectory;
use crate::shared::health;
use crate::shared::shapes::{NamedShape, TipShapes};

/// Recordings that are drawn at most, where there are not more families.
const MAX_SHOWN: usize = 9;

/// Everything the report may show.
pub(super) struct DataSet<'a> {
    /// Of what, for the title.
    pub title: &'a str,
    /// Angles of the tendons about z [rad].
    pub angles: &'a [f64],
    /// One per trajectory.
    pub rows: &'a [RecordedTrajectory],
    /// The same, with their names.
    pub recordings: &'a [(String, Recording)],
    /// Provenance of the first.
    pub meta: &'a Metadata,
    /// Condition of the servos, from these recordings.
    pub health: Option<&'a Health>,
}

/// Writes the figures, `report.html` and `metrics.json` to `folder`; the outcome with the shapes that the figures show.
pub(super) fn write(folder: &ReportFolder, data: &DataSet) -> anyhow::Result<Outcome> {
    let (shown, n_more) = representatives(data.recordings);
    let moving: Vec<(&str, &Recording)> =
        shown.iter().copied().filter(|it| has_shape(data.angles, it)).collect();
    let figure = if moving.is_empty() { None } else { TipShapes::new(data.angles, &moving).ok() };
    let drawn = figure.as_ref().map(|shapes| folder.save(&shapes.figure())).transpose()?;
    let outcome = Outcome {
        tip_range_m: Some(tip_range(data.recordings)),
        shapes: figure.map_or(vec![], |figure| figure.numbers()),
        health: data.health.cloned(),
        ..Outcome::new(data.rows, data.meta)
    };
    folder.write_metrics(&outcome)?;

    let about = "Commanded strokes, loads and measured tip of every trajectory, on one clock.";
    let [across, along, up] = tip_range(data.recordings).map(|[low, high]| 1e3 * (high - low));
    let conclusion = format!(
        "{} trajectories, {} samples: the tip moved over {across:.2} x {along:.2} x {up:.2} mm.",
        outcome.trajectories.len(),
        outcome.samples
    );
    let mut page = Page::concluded(data.title, &conclusion, about, &outcome.command);
    let mm = |[low, high]: [f64; 2]| format!("{:.2} to {:.2}", 1e3 * low, 1e3 * high);
    let [x, y, z] = tip_range(data.recordings).map(mm);
    page.heading("Results");
    page.list([
        ("Samples", outcome.samples.to_string()),
        ("Samples filled in", filled_in(data.recordings).to_string()),
        ("Tip x [mm]", x),
        ("Tip y [mm]", y),
        ("Tip z [mm]", z),
    ]);
    page.table(&RecordedTrajectory::HEADINGS, data.rows.iter().map(RecordedTrajectory::cells));
    if !outcome.shapes.is_empty() {
        page.table(&NamedShape::HEADINGS, outcome.shapes.iter().map(NamedShape::cells));
    }
    if let Some(health) = data.health {
        health::section(&mut page, folder, health)?;
    }
    page.heading("Figures");
    if n_more > 0 {
        page.paragraph(&format!(
            "{} of {} recordings: every family is among them.",
            shown.len(),
            shown.len() + n_more
        ));
    }
    if let Some(figure) = &drawn {
        page.figure(figure);
    }
    for (name, recording) in shown {
        folder.add(&mut page, &over_time(name, recording))?;
    }
    folder.write_page(page, &outcome.commit)?;
    Ok(outcome)
}

fn filled_in(recordings: &[(String, Recording)]) -> usize {
    recordings.iter().flat_map(|(_, recording)| recording.gap()).filter(|gap| **gap).count()
}

/// Whether a recording moved enough to be drawn as command and tip.
fn has_shape(angles: &[f64], recording: &(&str, &Recording)) -> bool {
    TipShapes::new(angles, std::slice::from_ref(recording)).is_ok()
}

/// The recordings that are shown, and how many are not: the first of every family, then those that are not for
/// training, then others in the order of the plan.
fn representatives(recordings: &[(String, Recording)]) -> (Vec<(&str, &Recording)>, usize) {
    let key = |k: usize, key: &str| recordings[k].1.meta().extra.get(key).cloned().unwrap_or_default();
    let is_first = |k: usize| (0..k).all(|earlier| key(earlier, "plan.family") != key(k, "plan.family"));
    let rank = |k: usize| match key(k, "plan.role").as_str() {
        _ if is_first(k) => 0,
        "training" => 2,
        _ => 1,
    };
    let mut order: Vec<usize> = (0..recordings.len()).collect();
    order.sort_by_key(|k| rank(*k));
    order.truncate(MAX_SHOWN.max(order.iter().filter(|k| rank(**k) == 0).count()));
    order.sort_unstable();
    let shown = order.iter().map(|k| (recordings[*k].0.as_str(), &recordings[*k].1)).collect();
    (shown, recordings.len() - order.len())
}

/// Strokes, loads and tip of a recording over time; what was not measured is shaded and has no line.
fn over_time(name: &str, recording: &Recording) -> TimeChart {
    let (time, gap) = (recording.time(), recording.gap());
    let strokes = recording.strokes().into_iter().map(millimetres).collect();
    let mut panels = numbered_panels("stroke [mm]", "tendon", strokes);
    let measured = |stem: &str, unit: &str| -> Vec<Vec<f64>> {
        recording.numbered(stem, unit).into_iter().map(|values| without_gaps(values, gap)).collect()
    };
    for (label, stem, unit) in
        [("load [-]", "load", ""), ("tension [N]", "tension", "n"), ("current [A]", "current", "a")]
    {
        let series = measured(stem, unit);
        if !series.is_empty() {
            panels.extend(numbered_panels(label, "tendon", series));
        }
    }
    if let Some(tip) = recording.tip() {
        panels.extend(tip_panels(&[TipSeries::new("measured tip", MEASURED, &tip).without_gaps(gap)]));
    }
    let caption = "Commanded strokes [mm], loads as the servos report them, as a part of their largest, and measured tip \
                   [mm], over time [s]. Shaded: samples that were not measured and are filled in. Each panel has its own \
                   scale.";
    let chart = TimeChart::over_time(format!("{name}-time"), name, caption, time, panels);
    TimeChart { shaded: vec![Shaded { name: "filled in".into(), spans: spans(time, gap) }], ..chart }
}

fn tip_range(recordings: &[(String, Recording)]) -> [[f64; 2]; 3] {
    let mut range = [[f64::INFINITY, f64::NEG_INFINITY]; 3];
    for tip in recordings.iter().filter_map(|(_, recording)| recording.tip()) {
        for (range, values) in range.iter_mut().zip(tip) {
            for value in values {
                *range = [range[0].min(*value), range[1].max(*value)];
            }
        }
    }
    // Without a tip there is no range.
    range.map(|[low, high]| if low <= high { [low, high] } else { [0.0, 0.0] })
}
