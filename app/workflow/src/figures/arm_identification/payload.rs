//! The report of `arm identify payload`.

use std::path::Path;

use hysteron_arm::Model;
use hysteron_report::figure::save;

use super::relative_errors;
use crate::Context;
use crate::arm::identify::{Row, Summary};

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
pub(crate) fn write(
    folder: &Path,
    shown: &Shown,
    summary: &Summary,
    png: bool,
    context: &Context,
) -> anyhow::Result<()> {
    let about = format!(
        "A body at {} of {} from what the torques are beyond those of the bare arm, which was identified first.",
        shown.frame,
        shown.model.name()
    );
    let mut page = super::page(folder, "Identified payload", summary, &about, context)?;
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
    super::finish(folder, page, summary)
}
