//! The page of an import: every channel over time, with its unit, range and rate.

use hysteron_base::Recording;
use hysteron_report::folder::ReportFolder;
use hysteron_report::lines::{Curve, Shaded, TimeChart, TimePanel, spans, without_gaps};
use hysteron_report::page::Page;

use super::outcome::{ChannelRange, Imported, ImportedRecording, shown_unit};

/// Recordings that are drawn.
const MAX_SHOWN: usize = 9;
/// Panels of a recording.
const MAX_PANELS: usize = 40;

/// Writes figures, `report.html` and `metrics.json` to `folder`.
///
/// # Errors
/// Files that cannot be written.
pub(super) fn write(
    folder: &ReportFolder,
    outcome: &Imported,
    recordings: &[Recording],
) -> anyhow::Result<()> {
    folder.write_metrics(outcome)?;
    let about = "Every channel as it was imported, with its unit, range and rate.";
    let mut page = Page::concluded("Import", &outcome.verdict, about, &outcome.command);
    page.heading("Recordings");
    let row = |one: &ImportedRecording| {
        vec![
            one.out.display().to_string(),
            one.episode.clone().unwrap_or_default(),
            one.rows.to_string(),
            one.rate(),
            format!("{:.2}", one.duration_s),
            one.gaps.to_string(),
            one.left_out.to_string(),
        ]
    };
    let headings = ["Recording", "Episode", "Samples", "Rate", "Duration [s]", "Gaps", "Rows skipped"];
    page.table(&headings, outcome.recordings.iter().map(row));
    page.heading("Channels");
    for one in outcome.recordings.iter().take(MAX_SHOWN) {
        let row = |c: &ChannelRange| {
            let changes = format!("{:.0}", 100.0 * c.changes_ratio);
            vec![
                c.name.clone(),
                c.unit.clone(),
                format!("{:.4}", c.smallest),
                format!("{:.4}", c.largest),
                changes,
            ]
        };
        page.table(
            &["Channel", "Unit", "Smallest", "Largest", "Samples that change [%]"],
            one.channels.iter().map(row),
        );
    }
    page.heading("Figures");
    if recordings.len() > MAX_SHOWN {
        page.paragraph(&format!("The first {MAX_SHOWN} of {} recordings.", recordings.len()));
    }
    for (one, recording) in outcome.recordings.iter().zip(recordings).take(MAX_SHOWN) {
        let name = one.out.file_stem().unwrap_or_default().to_string_lossy();
        folder.add(&mut page, &over_time(&name, recording))?;
    }
    folder.write_page(page, &outcome.commit)
}

/// Small panels, one for each family of channels (`q_1_rad`, `q_2_rad`, …) or single channel.
fn over_time(name: &str, recording: &Recording) -> TimeChart {
    let mut panels: Vec<(String, TimePanel)> = Vec::new();
    for channel in recording.channels() {
        let (unit, written) = shown_unit(&channel.name);
        let family = hysteron_base::units::Unit::of_name(&channel.name)
            .map_or(channel.name.as_str(), |(stem, _)| stem);
        let family = family.trim_end_matches(|c: char| c.is_ascii_digit()).trim_end_matches('_').to_owned();
        let shown: Vec<f64> =
            channel.values.iter().map(|x| unit.map_or(*x, |unit| unit.from_si(*x))).collect();
        let values = without_gaps(&shown, recording.gap());
        let label = format!("{family} [{written}]");
        let curve = |k: usize| Curve::new(channel.name.clone(), k, values.clone());
        match panels.iter_mut().find(|(known, _)| *known == label) {
            Some((_, panel)) => panel.curves.push(curve(panel.curves.len())),
            None => panels.push((label.clone(), TimePanel::new(label, vec![curve(0)]))),
        }
    }
    panels.truncate(MAX_PANELS);
    let caption = "Every channel over time [s]. Shaded: samples that were missing and are filled in. Each panel has its own scale.";
    let panels = panels.into_iter().map(|(_, panel)| panel).collect();
    let chart = TimeChart::over_time(format!("{name}-time"), name, caption, recording.time(), panels);
    let filled = Shaded { name: "filled in".into(), spans: spans(recording.time(), recording.gap()) };
    TimeChart { shaded: vec![filled], ..chart }
}
