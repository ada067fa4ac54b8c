//! The page of `train`.

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
    let training = &outcome.training;
    let validated = match training.folds {
        Some(n) => format!("each left out of one of {n} fits that the errors are of"),
        None => format!("and {} to validate on and stop by", training.held_out.len()),
    };
    let page = TrainingPage {
        title: "Inverse controller",
        about: format!(
            "From the path of a tip to strokes: {} recordings to learn from, {validated}.",
            training.trained_on.len(),
        ),
        verdict: &outcome.verdict,
        compared: outcome.rows(),
        networks: &outcome.networks,
        facts: facts(outcome),
        warnings: &outcome.warnings,
        recording_warnings: &outcome.recording_warnings,
        training: json::to_text(&outcome.training)?,
        command: &outcome.command,
        commit: &outcome.commit,
    };
    page.write(folder)
}

/// Names and values of the numbers that are not errors in validation.
fn facts(outcome: &Outcome) -> Vec<(&'static str, String)> {
    let training = &outcome.training;
    let delay = training.delay_s.unwrap_or(f64::NAN);
    let mut facts = vec![("Delay of the tip behind the strokes [ms]", format!("{:.0}", 1e3 * delay))];
    facts.extend(training.weights.map(|errors| {
        (
            "What 16-bit weights change of the strokes in validation, rms and largest [mm]",
            format!("{:.1e}, {:.1e}", errors.stroke_rmse_mm, errors.stroke_largest_mm),
        )
    }));
    facts.extend(training.gradient_floor_relative_error.map(|error| {
        ("What the floor of derivatives takes from the gradient, over its length", format!("{error:.1e}"))
    }));
    facts
}
