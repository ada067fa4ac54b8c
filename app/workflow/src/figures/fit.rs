//! The report of a fit: parameters, errors, and the tip before and after over the measured one.

use hysteron_base::json;
use std::path::Path;

use hysteron_twin::fit::{Identifiability, ParameterScale};
use serde::Serialize;
use serde_json::Value;

use crate::shared::recording_checks::Findings;
use crate::tendon::fit_material::{Outcome, digits, standing};
use crate::{COMMIT, Context};
use hysteron_report::figure::{register_embedded_font, save};
use hysteron_report::lines::{Curve, TimeChart, TimePanel};
use hysteron_report::page::{Page, write_metrics, write_page};
use hysteron_report::series::{MEASURED, TWIN, UNCORRECTED};
use hysteron_report::verdict::Verdict;

#[derive(Serialize)]
struct Metrics<'a> {
    format: &'static str,
    version: u32,
    /// Whether the fitted scene can be used.
    verdict: Verdict,
    robot: &'a str,
    scene_sha256: &'a str,
    parameters: Vec<ParameterRow<'a>>,
    /// Rows and columns in the order of the parameters; zero where one was not fitted.
    correlation: &'a [Vec<f64>],
    errors_before: Errors,
    errors_after: Errors,
    /// Of the fitted scene [m/s²].
    gravity_m_s2: [f64; 3],
    /// Largest tension of every tendon with the fitted scene [N].
    largest_tensions_n: &'a [f64],
    /// Warnings about the result, and other explanations of the errors that are left.
    doubts: &'a [String],
    /// Warnings about its recordings.
    recording_warnings: &'a Findings,
    recordings: usize,
    recordings_of_another_role: usize,
    rows: usize,
    /// Of an evaluation.
    steps: usize,
    condition: f64,
    constant_channels: usize,
    residuals: usize,
    effective_residuals: f64,
    iterations: usize,
    evaluations: usize,
    ended: &'a str,
    converged: bool,
    command: &'a str,
    commit: &'a str,
}

/// Everything in SI.
#[derive(Serialize)]
struct ParameterRow<'a> {
    name: &'a str,
    start: f64,
    value: f64,
    standard_error: Option<f64>,
    lower_bound: f64,
    upper_bound: f64,
    /// Standard deviation of the prior; a factor on a logarithmic scale.
    prior_width: Option<f64>,
    is_at_bound: bool,
    standing: String,
}

#[derive(Serialize)]
struct Errors {
    rmse_axes_m: [f64; 3],
    rmse_distance_m: f64,
}

/// Writes the figures, `report.html` and `metrics.json` to `folder`.
pub(crate) fn write(
    folder: &Path,
    outcome: &Outcome,
    with_png: bool,
    context: &Context,
) -> anyhow::Result<Value> {
    register_embedded_font()?;
    let figures = [chart(outcome, Shown::Tips), chart(outcome, Shown::Errors)];
    let drawn: Vec<_> =
        figures.iter().map(|figure| save(folder, figure, with_png)).collect::<anyhow::Result<_>>()?;
    let command = context.command.clone();
    let doubts = outcome.doubts();
    let metrics = metrics(outcome, &command, &doubts);
    let value = write_metrics(folder, &metrics)?;

    let about = format!(
        "Tip of {} in {} recordings, {} rows. Standard errors count {} residuals as {:.0} independent ones, for \
         neighbouring samples err alike; they say nothing of what the model leaves out.",
        metrics.robot, metrics.recordings, metrics.rows, metrics.residuals, metrics.effective_residuals,
    );
    let title = format!("{}: fitted parameters", metrics.robot);
    let mut page = Page::judged(&title, &metrics.verdict, &about, &command);
    page.table(
        &["Parameter", "Scene", "Fitted", "Standard error", "Bounds", "Believed within", "Standing"],
        rows(outcome),
    );
    let error_row = |name: &str, errors: &Errors| {
        let mm =
            errors.rmse_axes_m.iter().chain([&errors.rmse_distance_m]).map(|m| format!("{:.3}", 1e3 * m));
        std::iter::once(name.to_owned()).chain(mm).collect::<Vec<_>>()
    };
    page.table(
        &["RMSE of the tip [mm]", "x", "y", "z", "distance"],
        [error_row("scene", &metrics.errors_before), error_row("fitted", &metrics.errors_after)],
    );
    page.list(metrics.doubts.iter().map(|doubt| ("Doubt", doubt.clone())));
    page.table(&correlation_headings(&metrics), correlation_rows(&metrics));
    page.list([
        ("Search", metrics.ended.to_owned()),
        ("Iterations", metrics.iterations.to_string()),
        ("Evaluations", metrics.evaluations.to_string()),
        ("Steps of an evaluation", metrics.steps.to_string()),
        ("Condition number of the Jacobian, columns normalised", format!("{:.1}", metrics.condition)),
        ("Constant channels left out", metrics.constant_channels.to_string()),
        ("Recordings of another role left out", metrics.recordings_of_another_role.to_string()),
    ]);
    drawn.iter().for_each(|figure| page.figure(figure));
    outcome.findings.show(&mut page);
    page.small(&format!("Scene {}.", metrics.scene_sha256));
    write_page(folder, page.finish(metrics.commit))?;
    Ok(value)
}

/// The summary, where no report is asked for.
pub(crate) fn summarise(outcome: &Outcome, context: &Context) -> anyhow::Result<Value> {
    Ok(json::to_value(metrics(outcome, &context.command, &outcome.doubts()))?)
}

fn metrics<'a>(outcome: &'a Outcome, command: &'a str, doubts: &'a [String]) -> Metrics<'a> {
    let fit = &outcome.found.fit;
    let row = |(selected, estimate): (&hysteron_twin::fit::Selected, &'a hysteron_twin::fit::Estimate)| {
        ParameterRow {
            name: &estimate.name,
            start: estimate.start,
            value: estimate.value,
            standard_error: estimate.standard_error,
            lower_bound: selected.parameter.bounds.min,
            upper_bound: selected.parameter.bounds.max,
            prior_width: selected.parameter.prior.map(|prior| prior.width),
            is_at_bound: estimate.standing == Identifiability::AtBound,
            standing: standing(&estimate.standing),
        }
    };
    let errors = |k: usize| Errors {
        rmse_axes_m: outcome.found.errors[k].axes,
        rmse_distance_m: outcome.found.errors[k].distance,
    };
    let (motions, courses) = (outcome.motions, &outcome.found.courses);
    Metrics {
        format: "hysteron-metrics",
        version: 1,
        verdict: outcome.verdict(),
        robot: &outcome.scene.name,
        scene_sha256: &outcome.scene.hash,
        parameters: outcome.selected.iter().zip(&fit.estimates).map(row).collect(),
        correlation: &fit.correlation,
        errors_before: errors(0),
        errors_after: errors(1),
        gravity_m_s2: outcome.found.scene.gravity,
        largest_tensions_n: &outcome.found.tensions,
        doubts,
        recording_warnings: outcome.findings,
        recordings: motions.len(),
        recordings_of_another_role: outcome.n_other_role,
        rows: courses.iter().flat_map(|course| &course.tips).flatten().count(),
        steps: courses.iter().map(|course| course.samples.len()).sum(),
        condition: fit.condition,
        constant_channels: motions.iter().flat_map(|motion| motion.axes).filter(|is_used| !is_used).count(),
        residuals: fit.n_residuals,
        effective_residuals: fit.n_effective,
        iterations: fit.iterations,
        evaluations: fit.evaluations,
        ended: &fit.ended,
        converged: fit.is_converged,
        command,
        commit: COMMIT,
    }
}

/// Rows of the table of parameters, in the unit of their keys.
fn rows(outcome: &Outcome) -> Vec<Vec<String>> {
    let row = |(selected, estimate): (&hysteron_twin::fit::Selected, &hysteron_twin::fit::Estimate)| {
        let (factor, unit) = (selected.quantity.key.1, selected.quantity.unit());
        let own = |value: f64| digits(factor * value);
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
                (Some(prior), ParameterScale::Logarithmic) => format!("a factor of {}", digits(prior.width)),
            },
            standing(&estimate.standing),
        ]
    };
    outcome.selected.iter().zip(&outcome.found.fit.estimates).map(row).collect()
}

fn correlation_headings<'a>(metrics: &'a Metrics) -> Vec<&'a str> {
    std::iter::once("Correlation").chain(metrics.parameters.iter().map(|parameter| parameter.name)).collect()
}

fn correlation_rows(metrics: &Metrics) -> Vec<Vec<String>> {
    let row = |(parameter, row): (&ParameterRow, &Vec<f64>)| {
        let cells = row.iter().map(|value| format!("{value:.2}"));
        std::iter::once(parameter.name.to_owned()).chain(cells).collect()
    };
    metrics.parameters.iter().zip(metrics.correlation).map(row).collect()
}

#[derive(Clone, Copy, PartialEq)]
enum Shown {
    Tips,
    Errors,
}

/// The measured rows of all recordings, one after the other, with a panel for each coordinate.
fn chart(outcome: &Outcome, shown: Shown) -> TimeChart {
    let (mut time, mut offset) = (Vec::new(), 0.0);
    let mut values = [const { [const { Vec::new() }; 3] }; 3];
    for (m, (motion, course)) in outcome.motions.iter().zip(&outcome.found.courses).enumerate() {
        let times: Vec<f64> =
            course.samples.iter().map(|&sample| motion.time[sample] - motion.time[0]).collect();
        for (row, measured) in course.tips.iter().enumerate() {
            let Some(measured) = measured else { continue };
            time.push(offset + times[row]);
            for c in 0..3 {
                let tips = [0, 1].map(|k| outcome.found.tips[k][m][row][c]);
                let zero = if shown == Shown::Errors { measured[c] } else { 0.0 };
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
    let first = if shown == Shown::Errors { 1 } else { 0 };
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
        Shown::Tips => (
            "overlay",
            "Tip as measured, and of the twin before and after",
            "Tip as measured, with the scene as given and with the fitted one [mm], over time [s]; recordings one after \
             the other, each axis with its own scale.",
        ),
        Shown::Errors => (
            "residuals",
            "Error of the twin's tip",
            "Tip of the twin minus the measured one [mm], with the scene as given and with the fitted one, over time [s]; \
             each axis has its own scale.",
        ),
    };
    TimeChart::over_time(name, title, caption, &time, (0..3).map(panel).collect())
}
