//! The report of an identification.

use std::path::Path;

use hysteron_base::file;
use serde::Serialize;

use super::report::{Page, write_metrics};
use crate::identify::summary::Row;
use crate::terminal;

#[derive(Serialize)]
struct Metrics<'a> {
    format: &'static str,
    version: u32,
    recordings: &'a [Row],
    /// Why others were left out.
    left_out: &'a [String],
    scene_sha256: &'a str,
    command: &'a str,
    commit: &'a str,
}

/// Who chose the virtual strokes.
#[derive(Clone, Copy)]
pub enum Chosen {
    /// One QP a sample.
    ByQps,
    /// A network that was there already.
    ByNetwork,
}

/// Writes `report.html` and `metrics.json` to `folder`.
pub fn write(
    folder: &Path,
    title: &str,
    chosen: Chosen,
    scene_sha256: &str,
    rows: &[Row],
    left_out: &[String],
) -> anyhow::Result<()> {
    let (command, commit) = (terminal::command_line(), env!("HYSTERON_COMMIT"));
    let metrics = Metrics {
        format: "hysteron-metrics",
        version: 1,
        recordings: rows,
        left_out,
        scene_sha256,
        command: &command,
        commit,
    };
    write_metrics(folder, &metrics)?;
    let about = match chosen {
        Chosen::ByQps => {
            "Distance of the twin's tip from the measured one, without and with virtual tendons, and how often their bounds \
             bind."
        }
        Chosen::ByNetwork => {
            "Distance of the twin's tip from the measured one, without virtual tendons and with the strokes of the network: \
             what it leaves is for a second one to learn. Nothing was solved for."
        }
    };
    let mut page = Page::new(title, about, &command);
    page.table(&Row::HEADINGS, rows.iter().map(Row::cells));
    if !left_out.is_empty() {
        page.table(&["Left out"], left_out.iter().map(|why| vec![why.clone()]));
    }
    page.small(&format!("Scene {scene_sha256}."));
    file::write_bytes(&folder.join("report.html"), page.finish(commit))?;
    Ok(())
}
