//! The page of `arm identify payload`.

use hysteron_arm_dynamics::Model;

use hysteron_report::folder::ReportFolder;

use super::Outcome;
use crate::shared::identification::{ESTIMATE_HEADINGS, ParameterEstimate};
use crate::shared::identification_page::{begin, finish, relative_errors};

/// Writes the figure, `report.html` and `metrics.json` to `folder`.
pub(super) fn write(folder: &ReportFolder, model: &Model, outcome: &Outcome) -> anyhow::Result<()> {
    let about = format!(
        "A body at {} of {} from what the torques are beyond those of the bare arm, which was identified first.",
        outcome.frame, outcome.robot
    );
    let mut page =
        begin(folder, outcome, &outcome.verdict, ("Identified payload", &about, &outcome.command))?;
    page.table(&ESTIMATE_HEADINGS, outcome.estimates.iter().map(ParameterEstimate::cells));
    page.heading("Error of the torques, root mean square [N m]");
    let names = model.joints().iter().map(|joint| joint.name.as_str());
    let head: Vec<&str> = std::iter::once("").chain(names).collect();
    let rows = [
        ("bare arm", &outcome.rms_bare_n_m),
        ("loaded, payload unknown", &outcome.rms_without_n_m),
        ("loaded, payload known", &outcome.rms_with_n_m),
    ];
    page.table(
        &head,
        rows.map(|(kind, rms)| {
            std::iter::once(kind.to_owned()).chain(rms.iter().map(|x| format!("{x:.4}"))).collect()
        }),
    );
    page.heading("Figures");
    folder.add(&mut page, &relative_errors(&outcome.estimates))?;
    finish(folder, page, &outcome.recording_warnings)
}
