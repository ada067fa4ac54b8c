//! The training of an inverse controller: recordings, data set, network, checkpoint, page.

use std::borrow::Cow;
use std::path::PathBuf;

use hysteron_base::BadInput;
use hysteron_base::checks::{CheckContext, Purpose};
use hysteron_control::inverse::{
    Axes, BaseMap, Candidate, DataOrigin, Dataset, Demonstration, FittedController, Folds, LossWeights,
    PUBLISHED, RecurrentOptions, fit_base, fit_recurrent, fit_windowed,
};
use hysteron_learn::{Epoch, TrainingProgress, TrainingSession, WeightFormat};
use hysteron_report::folder::ReportFolder;

use super::compared::{ComparedController, ControllerComparison, candidates, training_file};
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
    let (mut folds, candidates) = folds(options, &inputs, context)?;
    context.listen();
    let judge = Judge::of(options, &mut folds, context)?;
    let unfinished = Unfinished::new(&options.out, training_files(options, &candidates, folds.len()));
    let (comparison, mut is_finished) = compared(options, (&folds, &candidates), judge.as_ref(), context)?;
    let chosen = comparison.best();
    let errors = comparison.errors(chosen);
    let chosen = &comparison.controllers[chosen];
    let mut model = chosen.last.model.clone();
    if is_finished && folds.len() > 1 {
        let fitted = fit_all(options, &folds, chosen, context)?;
        is_finished = fitted.is_finished;
        model = fitted.model;
    }
    let own_mm = judge.as_ref().and_then(|judge| judge.own_error_mm(folds.validated()));
    if judge.is_some() || !errors.is_empty() {
        model.training.candidate = Some(chosen.candidate);
    }
    let tip_mm = errors.iter().find(|one| one.is_chosen).and_then(|one| one.tip_rmse_mm);
    model.training.twin = leading_twin(options, judge.as_ref(), tip_mm, own_mm)?;
    model.training.provenance = Some(context.provenance());
    model.write(&options.out)?;
    let outcome = Outcome::new(&folds, (&comparison, errors, own_mm), &model.training, &findings, context);
    print(&outcome, context);
    page::write(&ReportFolder { path: &figures, png: false }, &outcome)?;
    context.reported(&figures);
    unfinished.end(is_finished, context)?;
    Ok(outcome)
}

/// The files from which trainings resume: of every network for every fold, and for all data.
fn training_files(options: &Options, candidates: &[Candidate], n_folds: usize) -> Vec<PathBuf> {
    let folds: Vec<Option<usize>> = (0..n_folds).filter(|_| n_folds > 1).map(Some).chain([None]).collect();
    let pairs = candidates.iter().flat_map(|one| folds.iter().map(move |fold| (*one, *fold)));
    pairs.filter_map(|(candidate, fold)| training_file(&options.out, candidate, fold)).collect()
}

/// Every controller on what each fold left out, and whether all trainings came to their end.
fn compared(
    options: &Options,
    (folds, candidates): (&Folds, &[Candidate]),
    judge: Option<&Judge>,
    context: &Context,
) -> anyhow::Result<(ControllerComparison, bool)> {
    let mut comparison = ControllerComparison::new(judge.is_some(), folds.len());
    for number in 0..folds.len() {
        let data = folds.fold(number);
        let fold = (folds.len() > 1).then_some(number);
        if fold.is_some() {
            tracing::info!("fold {} of {}", number + 1, folds.len());
        }
        let given_up: Vec<Candidate> =
            candidates.iter().copied().filter(|one| comparison.is_given_up(*one)).collect();
        for &candidate in candidates.iter().filter(|one| !given_up.contains(one)) {
            let known = known(&data, candidate);
            let settings = recurrent(options, candidate, folds);
            let fitted = fit((candidate, fold), &settings, options, &known, context)?;
            let is_finished = fitted.is_finished;
            comparison.add(candidate, fitted, judge, &data.validation, context)?;
            if !is_finished {
                return Ok((comparison, false));
            }
        }
    }
    Ok((comparison, true))
}

/// The data that a controller learns from: what a robot does is in its recordings, where there are some.
fn known(data: &Dataset, candidate: Candidate) -> Cow<'_, Dataset> {
    let recorded = match candidate {
        Candidate::Network => None,
        _ => data.only(DataOrigin::Real),
    };
    recorded.map_or(Cow::Borrowed(data), Cow::Owned)
}

/// The controller that was chosen, fitted to all data, for as many epochs as the folds found, with the errors of these.
fn fit_all(
    options: &Options,
    folds: &Folds,
    chosen: &ComparedController,
    context: &Context,
) -> anyhow::Result<FittedController> {
    let report = chosen.report();
    let mut settings = recurrent(options, chosen.candidate, folds);
    settings.learning.ends_after = chosen.candidate.is_network().then_some(report.epochs.max(1));
    let data = folds.whole();
    let known = known(&data, chosen.candidate);
    tracing::info!("{}, of all data", chosen.candidate.name());
    let mut fitted = fit((chosen.candidate, None), &settings, options, &known, context)?;
    let error = |k: usize| report.channels.iter().map(|channel| channel.errors[k]).collect();
    let training = &mut fitted.model.training;
    (training.base_stroke_rmse_mm, training.held_out_stroke_rmse_mm) = (error(0), error(1));
    training.folds = Some(folds.len());
    Ok(fitted)
}

/// Fits a controller, or goes on from the file of its training.
fn fit(
    (candidate, fold): (Candidate, Option<usize>),
    settings: &RecurrentOptions,
    options: &Options,
    data: &Dataset,
    context: &Context,
) -> anyhow::Result<FittedController> {
    if options.design == DesignName::Recurrent {
        tracing::info!("{}", candidate.name());
    }
    let mut display = EpochDisplay { bar: None, context };
    let mut progress = |progress: &TrainingProgress| display.show(progress);
    let file = training_file(&options.out, candidate, fold);
    let mut session = TrainingSession { file: file.as_deref(), progress: &mut progress };
    let fitted = match options.design {
        DesignName::Recurrent if candidate.is_network() => fit_recurrent(data, settings, &mut session),
        DesignName::Recurrent => fit_base(data, settings),
        DesignName::Paper => {
            let Options { epochs, hidden, seed, .. } = *options;
            fit_windowed(data, &options.paper.options(PUBLISHED, [epochs, hidden], seed), &mut session)
        }
    };
    display.end();
    Ok(fitted?)
}

/// The demonstrations in their folds, and the controllers to compare.
fn folds(options: &Options, inputs: &[Input], context: &Context) -> anyhow::Result<(Folds, Vec<Candidate>)> {
    let axes = if options.spatial { Axes::Spatial } else { Axes::Planar };
    let usable =
        inputs.iter().filter(|input| matches!(inputs::role(input.recording.meta()), "" | "training"));
    let demonstrations = usable.map(|input| {
        Demonstration::new(&input.name, &input.hash, &input.recording, axes)
            .map_err(|bad| bad.within(input.path.display()))
    });
    let all = demonstrations.collect::<Result<Vec<_>, BadInput>>()?;
    let candidates = candidates(options, &all);
    let folds = match options.n_folds(candidates.len()) {
        1 => Folds::single(all, &options.held_out, options.seed)?,
        n => Folds::new(all, n, options.seed)?,
    };
    let names: Vec<String> = folds.validated().map(|one| format!("{} ({})", one.name, one.kind())).collect();
    let how = match folds.len() {
        1 => String::new(),
        n => format!(" in {n} folds, each left out once"),
    };
    context.print(format_args!("validated on{how}: {}", names.join(", ")));
    let learned = if folds.len() > 1 { folds.whole() } else { folds.fold(0) };
    context.print(format_args!(
        "trained on: {} real and {} synthetic recordings, {} samples; {} skipped by their role",
        learned.count(DataOrigin::Real),
        learned.count(DataOrigin::Synthetic),
        learned.training.iter().map(Demonstration::len).sum::<usize>(),
        inputs.len() - folds.all().len(),
    ));
    Ok((folds, candidates))
}

fn recurrent(options: &Options, candidate: Candidate, folds: &Folds) -> RecurrentOptions {
    let default = RecurrentOptions::default();
    let is_recorded = candidate == Candidate::RecordedNetwork;
    let known = folds.all().iter().filter(|one| !is_recorded || one.origin == DataOrigin::Real);
    let longest = known.map(Demonstration::len).max().unwrap_or(0);
    let epochs = options.epochs.unwrap_or_else(|| default.epochs_for(longest));
    let co_contraction_min_m =
        options.co_contraction_min_mm.map_or(default.loss.co_contraction_min_m, |mm| 1e-3 * mm);
    RecurrentOptions {
        learning: default.learning.with([Some(epochs), options.hidden]),
        loss: LossWeights { co_contraction_min_m, ..default.loss },
        weights: match options.weights {
            Weights::Float32 => WeightFormat::Float32,
            Weights::Int16 => WeightFormat::Int16,
        },
        base: if candidate == Candidate::KernelRegression { BaseMap::Kernel } else { default.base },
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
