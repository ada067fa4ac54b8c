//! The training of an inverse controller: recordings, data set, network, checkpoint, page.

use hysteron_base::BadInput;
use hysteron_base::checks::{CheckContext, Purpose};
use hysteron_control::inverse::{
    Axes, Candidate, DataOrigin, Dataset, Demonstration, FittedController, LossWeights, PUBLISHED,
    RecurrentOptions, fit_recurrent, fit_regression, fit_windowed,
};
use hysteron_learn::{Epoch, TrainingProgress, TrainingSession, WeightFormat};
use hysteron_report::folder::ReportFolder;

use super::compared::{ComparedController, candidates, training_file};
use super::judge::Judge;
use super::leading_twin::leading_twin;
use super::options::{Options, Weights};
use super::outcome::Outcome;
use super::page;
use crate::shared::inputs::{self, Input};
use crate::shared::outputs::Outputs;
use crate::shared::paper_design::DesignName;
use crate::shared::paths;
use crate::shared::recording_checks;
use crate::shared::resume::Unfinished;
use crate::{Context, WorkflowError};

/// Runs the verb.
///
/// # Errors
/// Bad input; a training that fails or is interrupted before its first epoch is done; files that cannot be written.
pub fn run(options: &Options, context: &Context) -> Result<Outcome, WorkflowError> {
    Ok(train(options, context)?)
}

fn train(options: &Options, context: &Context) -> anyhow::Result<Outcome> {
    options.check()?;
    let inputs = inputs::read(&options.recordings)?;
    let outputs = Outputs::reading(inputs.iter().map(|input| &input.path)).and(&options.scene);
    let outputs = outputs.and(&options.residual).and(&options.body.reduced);
    let figures = paths::report_folder(&options.out, options.figures.as_deref());
    let outputs = outputs.file("--out", &options.out).report("--figures", Some(&figures));
    let _lock = outputs.check(context)?;
    let findings = recording_checks::of_inputs(&inputs, &CheckContext::new(Purpose::Fit))?;
    let mut data = dataset(options, &inputs, context)?;
    context.listen();
    let judge = Judge::of(options, &mut data, context)?;
    // What a robot does is in its recordings, where there are some.
    let recorded = judge.as_ref().and_then(|_| data.only(DataOrigin::Real));
    let candidates = candidates(options, &data, recorded.as_ref());
    let files = candidates.iter().filter_map(|one| training_file(&options.out, *one)).collect();
    let unfinished = Unfinished::new(&options.out, files);
    let mut compared: Vec<ComparedController> = Vec::new();
    for candidate in candidates {
        let known = recorded.as_ref().filter(|_| candidate != Candidate::Network).unwrap_or(&data);
        let fitted = fit(candidate, options, known, context)?;
        let is_finished = fitted.is_finished;
        compared.push(ComparedController::new(candidate, fitted, judge.as_ref(), &data, context)?);
        if !is_finished {
            break;
        }
    }
    let is_finished = compared.iter().all(|one| one.fitted.is_finished);
    let chosen = ComparedController::best(&compared);
    let own_mm = judge.as_ref().and_then(|judge| judge.own_error_mm(&data.validation));
    let twin = leading_twin(options, judge.as_ref(), compared[chosen].tip_mm, own_mm)?;
    let model = &mut compared[chosen].fitted.model;
    model.training.provenance = Some(context.provenance());
    model.training.twin = twin;
    model.write(&options.out)?;
    let outcome = Outcome::new(&data, (&compared, chosen, own_mm), &findings, context);
    print(&outcome, context);
    page::write(&ReportFolder { path: &figures, png: false }, &outcome)?;
    context.reported(&figures);
    unfinished.end(is_finished, context)?;
    Ok(outcome)
}

/// Fits a controller, or goes on from the file of its training.
fn fit(
    candidate: Candidate,
    options: &Options,
    data: &Dataset,
    context: &Context,
) -> anyhow::Result<FittedController> {
    if options.scene.is_some() {
        tracing::info!("{}", candidate.name());
    }
    let mut display = EpochDisplay { bar: None, context };
    let mut progress = |progress: &TrainingProgress| display.show(progress);
    let file = training_file(&options.out, candidate);
    let mut session = TrainingSession { file: file.as_deref(), progress: &mut progress };
    let fitted = match (candidate, options.design) {
        (Candidate::StaticRegression, _) => fit_regression(data, &recurrent(options)),
        (_, DesignName::Recurrent) => fit_recurrent(data, &recurrent(options), &mut session),
        (_, DesignName::Paper) => {
            let Options { epochs, hidden, seed, .. } = *options;
            fit_windowed(data, &options.paper.options(PUBLISHED, [epochs, hidden], seed), &mut session)
        }
    };
    display.end();
    Ok(fitted?)
}

fn dataset(options: &Options, inputs: &[Input], context: &Context) -> anyhow::Result<Dataset> {
    let axes = if options.spatial { Axes::Spatial } else { Axes::Planar };
    let usable =
        inputs.iter().filter(|input| matches!(inputs::role(input.recording.meta()), "" | "training"));
    let demonstrations = usable.map(|input| {
        Demonstration::new(&input.name, &input.hash, &input.recording, axes)
            .map_err(|bad| bad.within(input.path.display()))
    });
    let all = demonstrations.collect::<Result<Vec<_>, BadInput>>()?;
    let left_out = inputs.len() - all.len();
    let data = Dataset::new(all, &options.held_out, options.seed)?;
    let names: Vec<String> =
        data.validation.iter().map(|one| format!("{} ({})", one.name, one.kind())).collect();
    context.print(format_args!("validated on: {}", names.join(", ")));
    context.print(format_args!(
        "trained on: {} real and {} synthetic recordings, {} samples; {left_out} skipped by their role",
        data.count(DataOrigin::Real),
        data.count(DataOrigin::Synthetic),
        data.training.iter().map(Demonstration::len).sum::<usize>(),
    ));
    Ok(data)
}

fn recurrent(options: &Options) -> RecurrentOptions {
    let default = RecurrentOptions::default();
    let co_contraction_min_m =
        options.co_contraction_min_mm.map_or(default.loss.co_contraction_min_m, |mm| 1e-3 * mm);
    RecurrentOptions {
        learning: default.learning.with([options.epochs, options.hidden]),
        loss: LossWeights { co_contraction_min_m, ..default.loss },
        weights: match options.weights {
            Weights::Float32 => WeightFormat::Float32,
            Weights::Int16 => WeightFormat::Int16,
        },
        seed: options.seed,
        ..default
    }
}

/// A bar of all steps of the epoch, and a line per epoch.
struct EpochDisplay<'a> {
    bar: Option<Box<dyn crate::Progress>>,
    context: &'a Context<'a>,
}

impl EpochDisplay<'_> {
    /// False once the person has asked to stop.
    fn show(&mut self, progress: &TrainingProgress) -> bool {
        match progress {
            TrainingProgress::Step { done, of, .. } => {
                let bar = self.bar.get_or_insert_with(|| self.context.progress("steps of the epoch", *of, 0));
                bar.set_position(*done as u64);
            }
            TrainingProgress::Epoch(Epoch { number, of, training, validation, best }) => {
                self.end();
                tracing::info!(
                    "epoch {number}/{of}: {training:.3} mm, validation {validation:.3} mm, best {best:.3} mm"
                );
            }
        }
        !self.context.is_cancelled()
    }

    fn end(&mut self) {
        if let Some(bar) = self.bar.take() {
            bar.finish();
        }
    }
}

/// Prints the errors in validation and the warnings.
fn print(outcome: &Outcome, context: &Context) {
    for report in &outcome.networks {
        let line = |what: &str, errors: &[f64]| {
            let Some((network, baselines)) = errors.split_last() else { return };
            let named = report.methods.iter().zip(baselines);
            let baselines: Vec<String> = named.map(|(name, error)| format!("{name} {error:.4} mm")).collect();
            context.print(format_args!("{what} in validation: {network:.4} mm, {}", baselines.join(", ")));
        };
        report.channels.iter().for_each(|channel| line(&channel.name, &channel.errors));
        line("all strokes", &report.together());
    }
    for line in outcome.comparison() {
        context.print(line);
    }
    outcome.warnings.iter().for_each(|warning| tracing::warn!("{warning}"));
}
