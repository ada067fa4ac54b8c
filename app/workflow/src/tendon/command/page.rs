//! The page of a command: strokes for a path, and the path that they are for.

use hysteron_base::Recording;

use hysteron_report::folder::ReportFolder;
use hysteron_report::lines::{PanelScale, Shaded, TimeChart, TimePanel, spans};
use hysteron_report::page::Page;
use hysteron_report::series::{
    TARGET, TWIN, TipSeries, error_panel, millimetres, numbered_panels, tip_panels,
};
use hysteron_twin::residual::TipBand;

use super::outcome::Outcome;
use crate::shared::run::expected_within;

/// Writes the figures, `report.html` and `metrics.json` to `folder`.
pub(super) fn write(folder: &ReportFolder, outcome: &Outcome, recording: &Recording) -> anyhow::Result<()> {
    folder.write_metrics(outcome)?;
    let meta = recording.meta();
    let time = recording.time();
    let part = |flag: &str| {
        let flagged = recording.channel(flag).map_or(0.0, |values| values.iter().sum::<f64>());
        format!("{:.1}", 100.0 * flagged / time.len() as f64)
    };
    let strokes: Vec<Vec<f64>> = recording.strokes().into_iter().map(millimetres).collect();
    let range = strokes
        .iter()
        .flatten()
        .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| [low.min(*value), high.max(*value)]);
    let conclusion = format!(
        "Strokes for {:.2} s, limited in {} % of the samples; the network was outside its training in {} %.",
        time[time.len() - 1] - time[0],
        part("limited"),
        part("extrapolating")
    );
    let mut page = Page::concluded("Strokes for a path", &conclusion, &meta.source, &meta.command);
    page.heading("Results");
    page.list([
        ("Duration [s]", format!("{:.2}", time[time.len() - 1] - time[0])),
        ("Samples", time.len().to_string()),
        ("Strokes [mm]", format!("{:.2} to {:.2}", range[0], range[1])),
        ("Limited by stroke or rate [% of samples]", part("limited")),
        ("Network outside its training range [% of samples]", part("extrapolating")),
    ]);
    if let Some(radius) = outcome.tip_band_m {
        page.paragraph(&format!("{}.", expected_within(TipBand::LEVEL, radius)));
    }
    page.heading("Figures");
    for chart in [stroke_chart(recording, strokes), path_chart(recording)].into_iter().flatten() {
        folder.add(&mut page, &chart)?;
    }
    folder.write_page(page, &outcome.commit)
}

/// Strokes [mm], shaded where a flag is set.
fn stroke_chart(recording: &Recording, strokes: Vec<Vec<f64>>) -> Option<TimeChart> {
    let time = recording.time();
    let shaded = |(flag, name): (&str, &str)| {
        let flagged: Vec<bool> = recording.channel(flag)?.iter().map(|value| *value > 0.0).collect();
        Some(Shaded { name: name.to_owned(), spans: spans(time, &flagged) })
    };
    let flags =
        [("limited", "limited by stroke or rate"), ("extrapolating", "network outside its training range")];
    let chart = TimeChart::over_time(
        "commands",
        "Strokes",
        "Stroke of every tendon [mm] over time [s]; shaded where a limit reduced a stroke, or where the network was outside \
         its training range.",
        time,
        numbered_panels("stroke [mm]", "tendon", strokes),
    );
    Some(TimeChart {
        scale: PanelScale::Common,
        shaded: flags.into_iter().filter_map(shaded).collect(),
        ..chart
    })
}

/// The path [mm], with the tip of the twin and its error where there is one; `None` without a path.
fn path_chart(recording: &Recording) -> Option<TimeChart> {
    let tip = |stem: &str| -> Vec<&[f64]> {
        ["x", "y", "z"].iter().map_while(|axis| recording.channel(&format!("{stem}_{axis}_m"))).collect()
    };
    let (target, twin) = (tip("target"), tip("twin"));
    if target.is_empty() {
        return None;
    }
    let target = TipSeries::new("target", TARGET, &target);
    let mut tips = vec![target];
    if !twin.is_empty() {
        tips.push(TipSeries::new("twin", TWIN, &twin));
    }
    let mut panels: Vec<TimePanel> = tip_panels(&tips);
    if let [target, twin] = &tips[..] {
        panels.push(error_panel(target, std::slice::from_ref(twin)));
    }
    let caption = "Target of the tip [mm] over time [s], and, where strokes were found through the twin, the tip of the twin \
                   and its distance from the target; each panel has its own scale.";
    Some(TimeChart::over_time("path", "Target over time", caption, recording.time(), panels))
}
