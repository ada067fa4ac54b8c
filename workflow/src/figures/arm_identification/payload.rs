//! The report of `arm identify payload`.

use std::path::Path;

use hysteron_arm::Model;
use hysteron_report::figure::{register_embedded_font, save};
use hysteron_report::page::write_page;
use serde_json::Value;

use super::{metrics, relative_errors};
use crate::arm_identify::Row;
use crate::{COMMIT, Caller};

/// Content of the report.
pub struct Shown<'a> {
    /// The robot.
    pub model: &'a Model,
    /// Frame that holds the payload.
    pub frame: &'a str,
    /// The numbers that were found.
    pub rows: &'a [Row],
    /// Root mean square errors, joint by joint: of the bare arm, of the loaded one without and with the payload [N m].
    pub rms: [&'a [f64]; 3],
}

/// Writes the figure, `report.html` and `metrics.json` to `folder`.
pub fn write(
    folder: &Path,
    shown: &Shown,
    summary: &Value,
    png: bool,
    caller: &Caller,
) -> anyhow::Result<()> {
    register_embedded_font()?;
    metrics(folder, summary, caller)?;
    let about = format!(
        "A body at {} of {} from what the torques are beyond those of the bare arm, which was identified first.",
        shown.frame,
        shown.model.name()
    );
    let mut page = super::page("Identified payload", summary, &about, caller)?;
    page.table(&["Number", "Value", "Standard error", ""], shown.rows.iter().map(Row::cells));
    page.heading("Error of the torques, root mean square [N m]");
    let names = shown.model.joints().iter().map(|joint| joint.name.as_str());
    let head: Vec<&str> = std::iter::once("").chain(names).collect();
    let kinds = ["bare arm", "loaded, payload unknown", "loaded, payload known"];
    page.table(
        &head,
        kinds.iter().zip(shown.rms).map(|(kind, rms)| {
            std::iter::once((*kind).to_owned()).chain(rms.iter().map(|x| format!("{x:.4}"))).collect()
        }),
    );
    page.heading("Figures");
    page.figure(&save(folder, &relative_errors(shown.rows), png)?);
    write_page(folder, page.finish(COMMIT))
}
