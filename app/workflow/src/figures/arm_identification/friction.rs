//! The report of `arm identify friction`.

use std::path::Path;

use hysteron_report::figure::save;
use serde_json::Value;

use super::{
    JointSeries, errors_over_speed, errors_over_time, friction_curves, measured_over_predicted,
    relative_errors,
};
use crate::Context;
use crate::arm::identify::{Row, Summary};

/// Writes the figures, `report.html` and `metrics.json` to `folder`.
pub(crate) fn write(
    folder: &Path,
    law: &str,
    joint: &JointSeries,
    rows: &[Row],
    summary: &Summary,
    png: bool,
    context: &Context,
) -> anyhow::Result<()> {
    let about = format!("The law {law} fitted to torques over speeds of {}.", joint.name);
    let mut page = super::page(folder, "Identified friction", summary, &about, context)?;
    let rms = summary.value["rms_n_m"].as_f64().unwrap_or(f64::NAN);
    page.list([("Error, root mean square [N m]", format!("{rms:.4}"))]);
    page.table(&["Number", "Value", "Standard error", ""], rows.iter().map(Row::cells));
    let warnings = summary.value["warnings"].as_array().into_iter().flatten().filter_map(Value::as_str);
    warnings.for_each(|warning| page.paragraph(warning));
    page.heading("Figures");
    let joints = std::slice::from_ref(joint);
    let mut charts =
        vec![friction_curves(joints), errors_over_speed(joints), measured_over_predicted(joints)];
    if rows.iter().any(|row| row.standard_error.is_some()) {
        charts.push(relative_errors(rows));
    }
    for chart in charts {
        page.figure(&save(folder, &chart, png)?);
    }
    for chart in errors_over_time(joints) {
        page.figure(&save(folder, &chart, png)?);
    }
    super::finish(folder, page, summary)
}
