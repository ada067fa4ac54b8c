//! The strokes of a command, and the path that they are for.

use std::path::Path;

use hysteron_base::Recording;

use super::lines::{Curve, TimeChart, TimePanel};
use super::sheet::COLORS;
use super::{millimetres, register_embedded_font, save};

/// Writes `commands.svg` to `folder`.
pub fn write(folder: &Path, recording: &Recording) -> anyhow::Result<()> {
    register_embedded_font()?;
    let panel = |label: &str, curves: Vec<(String, &[f64])>| TimePanel {
        label: label.to_owned(),
        curves: curves
            .into_iter()
            .enumerate()
            .map(|(k, (name, values))| Curve {
                name,
                color: COLORS[k % COLORS.len()],
                width: 1.2,
                values: millimetres(values),
            })
            .collect(),
    };
    let strokes = recording.strokes().into_iter().enumerate();
    let path = ["x", "y"].map(|axis| (axis.to_owned(), recording.channel(&format!("target_{axis}_m"))));
    let path = path.into_iter().filter_map(|(name, values)| Some((name, values?))).collect();
    let chart = TimeChart {
        name: "commands",
        title: "Strokes for a path".into(),
        caption: "Strokes by the inverse controller, above the path that the tip shall follow.".into(),
        time: recording.time().to_vec(),
        panels: vec![
            panel("stroke [mm]", strokes.map(|(k, values)| (format!("stroke {}", k + 1), values)).collect()),
            panel("path [mm]", path),
        ],
    };
    save(folder, &chart, false)?;
    Ok(())
}
