//! The report of a training: learning curve, errors next to baselines, training trajectories.

use std::path::Path;

use hysteron_base::{file, json};
use hysteron_learn::FitReport;
use serde::Serialize;
use serde_json::Value;

use crate::shared::recording_checks::Findings;
use crate::{COMMIT, Context, shared::verdict};
use hysteron_report::figure::{register_embedded_font, save};
use hysteron_report::lines::{Curve, PanelScale, TimeChart, TimePanel};
use hysteron_report::page::{Page, write_metrics};
use hysteron_report::verdict::{Criterion, Verdict};

/// Content of a training's report.
pub(crate) struct Told<'a> {
    /// Title of the page.
    pub title: &'a str,
    /// Data and model of the training, in a sentence.
    pub about: String,
    /// One for each network.
    pub reports: &'a [FitReport],
    /// Training data in the checkpoint.
    pub training: &'a Value,
    /// Further lines: name and value.
    pub facts: Vec<(&'static str, String)>,
    /// Warnings about the result.
    pub warnings: &'a [String],
    /// Warnings about the recordings.
    pub findings: &'a Findings,
}

#[derive(Serialize)]
struct Metrics<'a> {
    format: &'static str,
    version: u32,
    /// Whether the networks can be used.
    verdict: Verdict,
    networks: &'a [FitReport],
    warnings: &'a [String],
    /// Warnings about its recordings.
    recording_warnings: &'a Findings,
    training: &'a Value,
    command: &'a str,
    commit: &'a str,
}

/// Sentences that say where networks do no better than a baseline.
pub fn losses(reports: &[FitReport]) -> Vec<String> {
    let of = |(number, report): (usize, &FitReport)| -> Vec<String> {
        let which = if reports.len() > 1 { format!("network {}, ", number + 1) } else { String::new() };
        let unit = report.unit;
        let sentence = |(channel, baseline, [theirs, ours]): (&str, &str, [f64; 2])| {
            format!(
                "{which}{channel}: {ours:.4} {unit} in validation, no better than {baseline} with {theirs:.4} {unit}"
            )
        };
        report.losses().into_iter().map(sentence).collect()
    };
    reports.iter().enumerate().flat_map(of).collect()
}

/// Whether networks do better in validation than the best of their baselines, and no worse than in training.
/// Of several, whose mean is used, the worst decides.
fn judged(reports: &[FitReport]) -> Verdict {
    let unit = reports.first().map_or("", |report| report.unit);
    // Network, and the best of its baselines with its name.
    let of = |report: &FitReport| {
        let errors = report.together();
        let (network, baselines) = errors.split_last()?;
        let named = baselines.iter().copied().zip(&report.methods);
        let (baseline, name) = named.min_by(|a, b| a.0.total_cmp(&b.0))?;
        Some((*network, baseline, name.clone()))
    };
    let compared: Vec<_> = reports.iter().filter_map(of).collect();
    let mean = compared.iter().map(|it| it.0).sum::<f64>() / compared.len().max(1) as f64;
    let claim = format!(
        "the network is off by {} {unit} on recordings that it did not learn from",
        verdict::digits(mean)
    );
    let worst = compared.iter().max_by(|a, b| (a.0 / a.1).total_cmp(&(b.0 / b.1)));
    let mut judged = Verdict::on(claim);
    if let Some((network, baseline, name)) = worst {
        judged = judged.because(
            Criterion::ErrorOverBaseline,
            verdict::ratio(*network, *baseline),
            format!(
                "in validation the network is off by {} {unit}, {name} by {} {unit}",
                verdict::digits(*network),
                verdict::digits(*baseline)
            ),
        );
    }
    let overfit = |report: &FitReport| {
        let [training, validation] = *report.curve.get(report.epochs.checked_sub(1)?)?;
        (training > 0.0).then_some(validation / training)
    };
    let largest = reports.iter().filter_map(overfit).max_by(f64::total_cmp);
    judged = judged.because_of(Criterion::HeldOutOverFitted, largest, |ratio| {
        format!("the error in validation is {} times that in training", verdict::digits(ratio))
    });
    let n = reports.iter().map(|report| report.validation.len()).min().unwrap_or(0);
    verdict::repeated(judged, n, "recording in validation").verdict()
}

/// Writes the figures, `report.html` and `metrics.json` to `folder`.
pub(crate) fn write(folder: &Path, told: &Told, context: &Context) -> anyhow::Result<Value> {
    register_embedded_font()?;
    let (command, commit) = (context.command.clone(), COMMIT);
    let metrics = Metrics {
        format: "hysteron-metrics",
        version: 1,
        verdict: judged(told.reports),
        networks: told.reports,
        warnings: told.warnings,
        recording_warnings: told.findings,
        training: told.training,
        command: &command,
        commit,
    };
    let value = write_metrics(folder, &metrics)?;
    let mut page = Page::judged(told.title, &metrics.verdict, &told.about, &command);
    told.warnings.iter().for_each(|warning| page.paragraph(&format!("Warning: {warning}.")));
    for (number, report) in told.reports.iter().enumerate() {
        if told.reports.len() > 1 {
            page.heading(&format!("Network {}", number + 1));
        }
        let errors = format!("Error in validation [{}]", report.unit);
        let headings: Vec<&str> =
            [&errors[..]].into_iter().chain(report.methods.iter().map(String::as_str)).collect();
        let cells = |name: &str, errors: &[f64]| -> Vec<String> {
            [name.to_owned()].into_iter().chain(errors.iter().map(|e| format!("{e:.4}"))).collect()
        };
        let rows = report.channels.iter().map(|channel| cells(&channel.name, &channel.errors));
        page.table(&headings, rows.chain([cells("all", &report.together())]));
        if report.curve.len() > 1 {
            page.figure(&save(folder, &learning_curve(number, report), false)?);
        }
        page.list([
            ("Validated on", report.validation.join(", ")),
            ("Learned from", report.training.join(", ")),
            (
                "Epochs, and after which the weights are kept",
                format!("{}, {}", report.curve.len(), report.epochs),
            ),
        ]);
    }
    page.list(told.facts.iter().map(|(name, value)| (*name, value.clone())));
    told.findings.show(&mut page);
    page.details("Options and data", &json::to_text(told.training)?);
    file::write_bytes(&folder.join("report.html"), page.finish(commit))?;
    context.reported(folder);
    Ok(value)
}

/// Errors over the epochs, on a logarithmic scale.
fn learning_curve(number: usize, report: &FitReport) -> TimeChart {
    let curve = |k: usize, name: &str| {
        let values = report.curve.iter().map(|errors| errors[k].max(f64::MIN_POSITIVE).log10());
        Curve::new(name, k, values.collect())
    };
    let panel = TimePanel::new(
        format!("log10 of the error [{}]", report.unit),
        vec![curve(0, "training"), curve(1, "validation")],
    );
    TimeChart {
        name: format!("learning-curve-{}", number + 1),
        title: "Learning curve".to_owned(),
        caption: format!(
            "Error after every epoch, in training (with its noise) and in validation. The weights after epoch {} are kept.",
            report.epochs
        ),
        x_name: "epoch",
        x: (1..=report.curve.len()).map(|epoch| epoch as f64).collect(),
        panels: vec![panel],
        shaded: Vec::new(),
        scale: PanelScale::Common,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hysteron_learn::ChannelErrors;

    #[test]
    fn a_report_says_where_a_network_loses_and_on_what_it_was_validated() -> anyhow::Result<()> {
        let folder = tempfile::tempdir()?;
        let report = FitReport {
            training: vec!["circle-1".to_owned()],
            validation: vec!["square-2".to_owned()],
            curve: vec![[3.0, 4.0], [2.0, 2.5], [1.5, 2.6]],
            epochs: 2,
            unit: "mm",
            methods: ["static regression", "network"].map(str::to_owned).to_vec(),
            channels: vec![ChannelErrors { name: "stroke 2".to_owned(), errors: vec![0.4, 0.5] }],
        };
        let reports = [report];
        let warnings = losses(&reports);
        assert_eq!(
            warnings,
            ["stroke 2: 0.5000 mm in validation, no better than static regression with 0.4000 mm"]
        );
        let told = Told {
            title: "Inverse controller",
            about: String::new(),
            reports: &reports,
            training: &Value::Null,
            facts: Vec::new(),
            warnings: &warnings,
            findings: &Findings::none(),
        };
        write(folder.path(), &told, &Context::silent("hysteron train"))?;
        let page = std::fs::read_to_string(folder.path().join("report.html"))?;
        assert!(
            ["Warning: stroke 2", "square-2", "circle-1", "Learning curve"]
                .iter()
                .all(|it| page.contains(it))
        );
        let metrics: Value = json::from_text(&std::fs::read(folder.path().join("metrics.json"))?)?;
        assert_eq!(metrics["networks"][0]["curve"][1][1], 2.5);
        assert_eq!(metrics["networks"][0]["validation"][0], "square-2");
        assert_eq!(metrics["verdict"]["usability"], "not_usable");
        assert!(page.find("class=\"verdict not-usable\"") < page.find("<pre>"), "the verdict comes first");
        Ok(())
    }
}
