//! The report of a data set: what was commanded, what the tip made of it, and how the rig kept its time.

use std::path::Path;

use hysteron_base::{Recording, file};
use serde::Serialize;

use super::report::{Page, write_metrics};
use super::shapes::{CommandAndTip, NamedShape};
use super::{register_embedded_font, save};
use crate::record::Row;

/// Everything the report may show.
pub struct DataSet<'a> {
    /// Of what, for the title.
    pub title: &'a str,
    /// Angles of the tendons about z [rad].
    pub angles: &'a [f64],
    /// One per trajectory.
    pub rows: &'a [Row],
    /// The same, with their names.
    pub recordings: &'a [(String, Recording)],
}

#[derive(Serialize)]
struct Metrics<'a> {
    format: &'static str,
    version: u32,
    samples: usize,
    /// Smallest and largest x, y and z of the tip over all recordings [m].
    tip_range_m: [[f64; 2]; 3],
    trajectories: &'a [Row],
    shapes: &'a [NamedShape],
    source: &'a str,
    command: &'a str,
    commit: &'a str,
}

/// Writes the figure, `report.html` and `metrics.json` to `folder`.
pub fn write(folder: &Path, data: &DataSet, with_png: bool) -> anyhow::Result<()> {
    register_embedded_font()?;
    let shown = representatives(data.recordings);
    let figure = CommandAndTip::new(data.angles, &shown).ok();
    let drawn = figure.as_ref().map(|figure| save(folder, figure, with_png)).transpose()?;
    let shapes = figure.map_or(vec![], |figure| figure.numbers());
    let Some((_, first)) = data.recordings.first() else { return Ok(()) };
    let meta = first.meta();
    let metrics = Metrics {
        format: "hysteron-metrics",
        version: 1,
        samples: data.recordings.iter().map(|(_, recording)| recording.n_samples()).sum(),
        tip_range_m: tip_range(data.recordings),
        trajectories: data.rows,
        shapes: &shapes,
        source: &meta.source,
        command: &meta.command,
        commit: &meta.commit,
    };
    write_metrics(folder, &metrics)?;

    let mut page = Page::new(data.title, &meta.source, &meta.command);
    let mm = |[low, high]: [f64; 2]| format!("{:.2} to {:.2}", 1e3 * low, 1e3 * high);
    let [x, y, z] = metrics.tip_range_m.map(mm);
    page.table(
        &["Samples", "Tip x [mm]", "Tip y [mm]", "Tip z [mm]"],
        [vec![metrics.samples.to_string(), x, y, z]],
    );
    page.table(&Row::HEADINGS, data.rows.iter().map(Row::cells));
    for NamedShape { name, numbers } in &shapes {
        page.shape(name, numbers);
    }
    if let Some(figure) = &drawn {
        page.figure(figure);
    }
    file::write_bytes(&folder.join("report.html"), page.finish(&meta.commit))?;
    Ok(())
}

/// The first recording of every family, and all that are not for training.
fn representatives(recordings: &[(String, Recording)]) -> Vec<(&str, &Recording)> {
    let key = |recording: &Recording, key: &str| recording.meta().extra.get(key).cloned().unwrap_or_default();
    let mut families = Vec::new();
    recordings
        .iter()
        .filter(|(_, recording)| {
            let family = key(recording, "plan.family");
            let is_new = !families.contains(&family);
            families.push(family);
            is_new || key(recording, "plan.role") != "training"
        })
        .map(|(name, recording)| (name.as_str(), recording))
        .collect()
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
