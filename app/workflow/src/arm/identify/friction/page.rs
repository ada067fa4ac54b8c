//! The page of `arm identify friction`.

use hysteron_report::folder::ReportFolder;

use super::Outcome;
use crate::shared::identification::{ESTIMATE_HEADINGS, ParameterEstimate};
use crate::shared::identification_page::{
    JointSeries, begin, errors_over_speed, errors_over_time, finish, friction_curves,
    measured_over_predicted, relative_errors,
};

/// Writes the figures, `report.html` and `metrics.json` to `folder`.
pub(super) fn write(folder: &ReportFolder, joint: &JointSeries, outcome: &Outcome) -> anyhow::Result<()> {
    let about = format!("The law {} fitted to torques over speeds of {}.", outcome.law, joint.name);
    let mut page =
        begin(folder, outcome, &outcome.verdict, ("Identified friction", &about, &outcome.command))?;
    page.list([("Error, root mean square [N m]", format!("{:.4}", outcome.rms_n_m))]);
    page.table(&ESTIMATE_HEADINGS, outcome.estimates.iter().map(ParameterEstimate::cells));
    outcome.warnings.iter().for_each(|warning| page.paragraph(warning));
    page.heading("Figures");
    let joints = std::slice::from_ref(joint);
    let mut charts =
        vec![friction_curves(joints), errors_over_speed(joints), measured_over_predicted(joints)];
    if outcome.estimates.iter().any(|estimate| estimate.standard_error.is_some()) {
        charts.push(relative_errors(&outcome.estimates));
    }
    for chart in charts {
        folder.add(&mut page, &chart)?;
    }
    for chart in errors_over_time(joints) {
        folder.add(&mut page, &chart)?;
    }
    finish(folder, page, &outcome.recording_warnings)
}
