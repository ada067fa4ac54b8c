//! The assessment and the page of a training: learning curve, errors next to those of baselines, training recordings.

use hysteron_base::checks::Warning;
use hysteron_base::number::digits;
use hysteron_learn::FitReport;
use hysteron_report::folder::ReportFolder;
use hysteron_report::lines::{Curve, PanelScale, TimeChart, TimePanel};
use hysteron_report::page::Page;
use hysteron_report::verdict::{Criterion, Verdict};

use crate::shared::recording_checks;
use crate::shared::verdict::{ratio, repeated};

/// Content of the page of a training.
pub(crate) struct TrainingPage<'a> {
    /// Title of the page.
    pub title: &'a str,
    /// Data and model of the training, in a sentence.
    pub about: String,
    /// Whether the networks can be used.
    pub verdict: &'a Verdict,
    /// Name, error of the strokes and error at the tip [mm] of controllers that were compared; empty where none were.
    pub compared: Vec<[String; 3]>,
    /// One for each network.
    pub networks: &'a [FitReport],
    /// Further lines: name and value.
    pub facts: Vec<(&'static str, String)>,
    /// Warnings about the result.
    pub warnings: &'a [String],
    /// Warnings about the recordings.
    pub recording_warnings: &'a [Warning],
    /// Training data in the checkpoint, as text.
    pub training: String,
    /// The command that made it.
    pub command: &'a str,
    /// Commit of the program.
    pub commit: &'a str,
}

/// Sentences that name the channels where networks are no better than a baseline.
pub(crate) fn losses(reports: &[FitReport]) -> Vec<String> {
    let of = |(number, report): (usize, &FitReport)| -> Vec<String> {
        let which = if reports.len() > 1 { format!("network {}, ", number + 1) } else { String::new() };
        let unit = &report.unit;
        let sentence = |(channel, baseline, [theirs, ours]): (&str, &str, [f64; 2])| {
            format!(
                "{which}{channel}: {ours:.4} {unit} in validation, no better than {baseline} with {theirs:.4} {unit}"
            )
        };
        report.losses().into_iter().map(sentence).collect()
    };
    reports.iter().enumerate().flat_map(of).collect()
}

/// Whether the last method of some reports does better in validation than the best of its baselines, and no worse than in
/// training. Of several networks, whose mean is used, the worst decides.
pub(crate) fn verdict(reports: &[FitReport]) -> Verdict {
    let unit = reports.first().map_or("", |report| &report.unit);
    let method = reports.first().and_then(|report| report.methods.last()).map_or("network", String::as_str);
    // It, and the best of its baselines with its name.
    let of = |report: &FitReport| {
        let errors = report.together();
        let (own, baselines) = errors.split_last()?;
        let named = baselines.iter().copied().zip(&report.methods);
        let (baseline, name) = named.min_by(|a, b| a.0.total_cmp(&b.0))?;
        Some((*own, baseline, name.clone()))
    };
    let compared: Vec<_> = reports.iter().filter_map(of).collect();
    let mean = compared.iter().map(|it| it.0).sum::<f64>() / compared.len().max(1) as f64;
    let claim =
        format!("the {method} is off by {} {unit} on recordings that it did not learn from", digits(mean));
    let worst = compared.iter().max_by(|a, b| (a.0 / a.1).total_cmp(&(b.0 / b.1)));
    let mut assessment = Verdict::on(claim);
    if let Some((own, baseline, name)) = worst {
        assessment = assessment.because(
            Criterion::ErrorOverBaseline,
            ratio(*own, *baseline),
            format!(
                "in validation the {method} is off by {} {unit}, {name} by {} {unit}",
                digits(*own),
                digits(*baseline)
            ),
        );
    }
    let overfit = |report: &FitReport| {
        let [training, validation] = *report.curve.get(report.epochs.checked_sub(1)?)?;
        (training > 0.0).then_some(validation / training)
    };
    let largest = reports.iter().filter_map(overfit).max_by(f64::total_cmp);
    assessment = assessment.because_of(Criterion::HeldOutOverFitted, largest, |ratio| {
        format!("the error in validation is {} times that in training", digits(ratio))
    });
    let n = reports.iter().map(|report| report.validation.len()).min().unwrap_or(0);
    repeated(assessment, n, "recording in validation").verdict()
}

impl TrainingPage<'_> {
    /// Writes the figures and `report.html` to `folder`.
    ///
    /// # Errors
    /// Files that cannot be written.
    pub fn write(&self, folder: &ReportFolder) -> anyhow::Result<()> {
        let mut page = Page::with_verdict(self.title, self.verdict, &self.about, self.command);
        self.warnings.iter().for_each(|warning| page.paragraph(&format!("Warning: {warning}.")));
        if !self.compared.is_empty() {
            page.heading("Controllers on recordings that they did not learn from");
            let headings = ["Controller", "Strokes, rms [mm]", "Tip of the twin, rms [mm]"];
            let is_judged = self.compared.iter().any(|[_, _, tip]| tip != "-");
            let n = if is_judged { 3 } else { 2 };
            page.table(&headings[..n], self.compared.iter().map(|row| row[..n].to_vec()));
            if is_judged {
                page.paragraph(
                    "The twin moves by the strokes of the controller and by the recorded ones; the distance of its tips counts. \
                     Where a tendon hangs loose, a stroke can be off without any effect on the tip. Behind ± stands the standard \
                     error, from the differences between recordings.",
                );
            }
        }
        for (number, report) in self.networks.iter().enumerate() {
            if self.networks.len() > 1 {
                page.heading(&format!("Network {}", number + 1));
            }
            network(&mut page, report);
            if report.curve.len() > 1 {
                folder.add(&mut page, &learning_curve(number, report))?;
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
        page.list(self.facts.iter().map(|(name, value)| (*name, value.clone())));
        recording_checks::show(self.recording_warnings, &mut page);
        page.details("Options and data", &self.training);
        folder.write_page(page, self.commit)
    }
}

/// The errors of a network in validation, channel by channel.
fn network(page: &mut Page, report: &FitReport) {
    let errors = format!("Error in validation [{}]", report.unit);
    let headings: Vec<&str> =
        [&errors[..]].into_iter().chain(report.methods.iter().map(String::as_str)).collect();
    let cells = |name: &str, errors: &[f64]| -> Vec<String> {
        [name.to_owned()].into_iter().chain(errors.iter().map(|e| format!("{e:.4}"))).collect()
    };
    let rows = report.channels.iter().map(|channel| cells(&channel.name, &channel.errors));
    page.table(&headings, rows.chain([cells("all", &report.together())]));
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
    fn a_page_names_losses_to_baselines_and_validation_recordings() -> anyhow::Result<()> {
        let folder = tempfile::tempdir()?;
        let networks = [FitReport {
            training: vec!["circle-1".to_owned()],
            validation: vec!["square-2".to_owned()],
            curve: vec![[3.0, 4.0], [2.0, 2.5], [1.5, 2.6]],
            epochs: 2,
            unit: "mm".into(),
            methods: ["static regression", "network"].map(str::to_owned).to_vec(),
            channels: vec![ChannelErrors { name: "stroke 2".to_owned(), errors: vec![0.4, 0.5] }],
        }];
        let warnings = losses(&networks);
        assert_eq!(
            warnings,
            ["stroke 2: 0.5000 mm in validation, no better than static regression with 0.4000 mm"]
        );
        let verdict = verdict(&networks);
        assert_eq!(verdict.usability, hysteron_report::verdict::Usability::NotUsable);
        let page = TrainingPage {
            title: "Inverse controller",
            about: String::new(),
            verdict: &verdict,
            compared: Vec::new(),
            networks: &networks,
            facts: Vec::new(),
            warnings: &warnings,
            recording_warnings: &[],
            training: "{}".to_owned(),
            command: "hysteron train",
            commit: "",
        };
        page.write(&ReportFolder { path: folder.path(), png: false })?;
        let page = std::fs::read_to_string(folder.path().join("report.html"))?;
        assert!(
            ["Warning: stroke 2", "square-2", "circle-1", "Learning curve"]
                .iter()
                .all(|it| page.contains(it))
        );
        assert!(page.find("class=\"verdict not-usable\"") < page.find("<pre>"), "the verdict comes first");
        Ok(())
    }
}
