//! The page of `fit-residual`.

use hysteron_base::json;
use hysteron_report::folder::ReportFolder;

use super::outcome::Outcome;
use crate::shared::training::TrainingPage;

/// Writes the figures, `report.html` and `metrics.json` to `folder`.
///
/// # Errors
/// Files that cannot be written.
pub(super) fn write(folder: &ReportFolder, outcome: &Outcome) -> anyhow::Result<()> {
    folder.write_metrics(outcome)?;
    let floor = outcome.training.gradient_floor_relative_error.map(|error| {
        ("What the floor of derivatives takes from the gradient, over its length", format!("{error:.1e}"))
    });
    let page = TrainingPage {
        title: "Residual network",
        about: format!(
            "What the twin misses of the robot, learned from identified recordings; {} networks, of which the mean is taken. \
             Errors are those of the tip through the linearised twin, root mean square.",
            outcome.networks.len()
        ),
        verdict: &outcome.verdict,
        compared: Vec::new(),
        networks: &outcome.networks,
        facts: floor.into_iter().collect(),
        warnings: &outcome.warnings,
        recording_warnings: &outcome.recording_warnings,
        training: json::to_text(&outcome.training)?,
        command: &outcome.command,
        commit: &outcome.commit,
    };
    page.write(folder)
}
