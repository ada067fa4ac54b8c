//! The page of `fit-material`: parameters, errors, and the tip before and after over the measured one.

use hysteron_base::number::significant;
use hysteron_report::folder::ReportFolder;
use hysteron_report::lines::{Curve, TimeChart, TimePanel};
use hysteron_report::page::Page;
use hysteron_report::series::{MEASURED, TWIN, UNCORRECTED};
use hysteron_twin::fit::{IdentifiedParameter, ParameterScale, Selected};

use super::outcome::{FittedParameter, FittedTipErrors, N_DIGITS, Outcome, identifiability};
use super::verdict::FinishedFit;
use crate::shared::recording_checks;

/// Writes the figures, `report.html` and `outcome.json` to `folder`.
pub(super) fn write(folder: &ReportFolder, outcome: &Outcome, finished: &FinishedFit) -> anyhow::Result<()> {
    folder.write_metrics(outcome)?;
    let about = format!(
        "Tip of {} in {} recordings, {} rows. Standard errors count {} residuals as {:.0} independent ones, for \
         neighbouring samples err alike; they say nothing of what the model leaves out.",
        outcome.robot, outcome.recordings, outcome.rows, outcome.residuals, outcome.effective_residuals,
    );
    let title = format!("{}: fitted parameters", outcome.robot);
    let mut page = Page::with_verdict(&title, &outcome.verdict, &about, &outcome.command);
    page.table(
        &["Parameter", "Scene", "Fitted", "Standard error", "Bounds", "Believed within", "Identifiability"],
        rows(finished),
    );
    let error_row = |name: &str, errors: &FittedTipErrors| {
        let mm =
            errors.rmse_axes_m.iter().chain([&errors.rmse_distance_m]).map(|m| format!("{:.3}", 1e3 * m));
        std::iter::once(name.to_owned()).chain(mm).collect::<Vec<_>>()
    };
    page.table(
        &["RMSE of the tip [mm]", "x", "y", "z", "distance"],
        [error_row("scene", &outcome.errors_before), error_row("fitted", &outcome.errors_after)],
    );
    page.list(outcome.warnings.iter().map(|warning| ("Warning", warning.clone())));
    page.table(&correlation_headings(outcome), correlation_rows(outcome));
    page.list([
        ("Search", outcome.ended.clone()),
        ("Iterations", outcome.iterations.to_string()),
        ("Evaluations", outcome.evaluations.to_string()),
        ("Steps of an evaluation", outcome.steps.to_string()),
        ("Condition number of the Jacobian, columns normalised", format!("{:.1}", outcome.condition)),
        ("Constant channels skipped", outcome.constant_channels.to_string()),
        ("Recordings of another role skipped", outcome.recordings_of_another_role.to_string()),
    ]);
    for shown in [PlottedQuantity::Tips, PlottedQuantity::Errors] {
        folder.add(&mut page, &chart(finished, shown))?;
    }
    recording_checks::show(&outcome.recording_warnings, &mut page);
    page.small(&format!("Scene {}.", outcome.scene_sha256));
    folder.write_page(page, &outcome.commit)
}

/// Rows of the table of parameters, in the unit of their keys.
fn rows(finished: &FinishedFit) -> Vec<Vec<String>> {
    let row = |(selected, estimate): (&Selected, &IdentifiedParameter)| {
        let (factor, unit) = (selected.quantity.key.1, selected.quantity.unit());
        let own = |value: f64| significant(factor * value, N_DIGITS);
        let bounds = selected.parameter.bounds;
        vec![
            format!("{} [{}]", estimate.name, if unit.is_empty() { "-" } else { unit }),
            own(estimate.start),
            own(estimate.value),
            estimate.standard_error.map_or("-".into(), own),
            format!("{} to {}", own(bounds.min), own(bounds.max)),
            match (selected.parameter.prior, selected.parameter.scale) {
                (None, _) => "-".into(),
                (Some(prior), ParameterScale::Linear) => format!("± {}", own(prior.width)),
                (Some(prior), ParameterScale::Logarithmic) => {
                    format!("a factor of {}", significant(prior.width, N_DIGITS))
                }
            },
            identifiability(&estimate.identifiability),
        ]
    };
    finished.selected.iter().zip(&finished.found.fit.estimates).map(row).collect()
}

fn correlation_headings(outcome: &Outcome) -> Vec<&str> {
    std::iter::once("Correlation")
        .chain(outcome.parameters.iter().map(|parameter| parameter.name.as_str()))
        .collect()
}

fn correlation_rows(outcome: &Outcome) -> Vec<Vec<String>> {
    let row = |(parameter, row): (&FittedParameter, &Vec<f64>)| {
        let cells = row.iter().map(|value| format!("{value:.2}"));
        std::iter::once(parameter.name.clone()).chain(cells).collect()
    };
    outcome.parameters.iter().zip(&outcome.correlation).map(row).collect()
}

#[derive(Clone, Copy, PartialEq)]
enum PlottedQuantity {
    Tips,
    Errors,
}

/// The measured rows of all recordings, one after the other, with a panel for each coordinate.
fn chart(finished: &FinishedFit, shown: PlottedQuantity) -> TimeChart {
    let (mut time, mut offset) = (Vec::new(), 0.0);
    let mut values = [const { [const { Vec::new() }; 3] }; 3];
    for (m, (motion, course)) in finished.motions.iter().zip(&finished.found.courses).enumerate() {
        let times: Vec<f64> =
            course.samples.iter().map(|&sample| motion.time[sample] - motion.time[0]).collect();
        for (row, measured) in course.tips.iter().enumerate() {
            let Some(measured) = measured else { continue };
            time.push(offset + times[row]);
            for c in 0..3 {
                let tips = [0, 1].map(|k| finished.found.tips[k][m][row][c]);
                let zero = if shown == PlottedQuantity::Errors { measured[c] } else { 0.0 };
                values[0][c].push(1e3 * measured[c]);
                values[1][c].push(1e3 * (tips[0] - zero));
                values[2][c].push(1e3 * (tips[1] - zero));
            }
        }
        // A second between recordings keeps the times in order, and a row without values parts their lines.
        time.push(offset + times[times.len() - 1] + 0.5);
        values.iter_mut().flatten().for_each(|values| values.push(f64::NAN));
        offset += times[times.len() - 1] + 1.0;
    }
    let names = ["measured", "scene", "fitted"];
    let colors = [MEASURED, UNCORRECTED, TWIN];
    let first = if shown == PlottedQuantity::Errors { 1 } else { 0 };
    let panel = |c: usize| TimePanel {
        label: format!("{} [mm]", ["x", "y", "z"][c]),
        curves: (first..3)
            .map(|k| Curve {
                name: names[k].into(),
                color: colors[k],
                width: 1.2,
                values: values[k][c].clone(),
            })
            .collect(),
    };
    let (name, title, caption) = match shown {
        PlottedQuantity::Tips => (
            "overlay",
            "Tip as measured, and of the twin before and after",
            "Tip as measured, with the scene as given and with the fitted one [mm], over time [s]; recordings one after \
             the other, each axis with its own scale.",
        ),
        PlottedQuantity::Errors => (
            "residuals",
            "Error of the twin's tip",
            "Tip of the twin minus the measured one [mm], with the scene as given and with the fitted one, over time [s]; \
             each axis has its own scale.",
        ),
    };
    TimeChart::over_time(name, title, caption, &time, (0..3).map(panel).collect())
}
