//! `hysteron train`: the inverse controller, from recordings of a rig and of a twin.

use std::path::PathBuf;

use hysteron_base::BadInput;
use hysteron_base::checks::{CheckContext, Purpose};
use hysteron_control::inverse::{
    Axes, DataOrigin, Dataset, Demonstration, FittedController, LossWeights, PUBLISHED, RecurrentOptions,
    fit_recurrent, fit_windowed,
};
use hysteron_learn::{Epoch, TrainingProgress, TrainingSession, WeightFormat};
use serde_json::Value;

use crate::Context;
use crate::figures::training::{self, Told};
use crate::shared::inputs::{self, Input};
use crate::shared::outputs::Outputs;
use crate::shared::paper_design::{DesignName, PaperDesign};
use crate::shared::paths;
use crate::shared::recording_checks::{self, Findings};
use crate::shared::resume::Unfinished;

/// Train the inverse controller on recordings (EDIC)
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    /// Recordings, or folders of them
    #[cfg_attr(feature = "clap", arg(required = true, value_name = "REC"))]
    pub recordings: Vec<PathBuf>,
    /// Checkpoint to write, .safetensors
    #[cfg_attr(feature = "clap", arg(long, value_name = "CKPT"))]
    pub out: PathBuf,
    /// Which network
    #[cfg_attr(feature = "clap", arg(long, value_enum, default_value_t = DesignName::Recurrent))]
    pub design: DesignName,
    /// Where the tip shall be in x, y and z, for a robot of several segments; else in x and y
    #[cfg_attr(feature = "clap", arg(long))]
    pub spatial: bool,
    /// A recording to validate on and stop by, by name; may be given several times [default: a sixth of every kind
    /// of motion and at least one of each that has two, drawn by the seed; a kind is the family of the plan, or what
    /// the strokes tell]
    #[cfg_attr(feature = "clap", arg(long, value_name = "NAME", value_delimiter = ','))]
    pub held_out: Vec<String>,
    /// Epochs at most [default: 30]
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", value_parser = crate::shared::number::count::<{ hysteron_learn::MAX_EPOCHS }>))]
    pub epochs: Option<usize>,
    /// Hidden units of a layer [default: 128; paper: 512]
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", value_parser = crate::shared::number::count::<{ hysteron_learn::MAX_HIDDEN }>))]
    pub hidden: Option<usize>,
    /// Pull that all tendons have in common at least, so that none goes slack; recurrent only
    #[cfg_attr(feature = "clap", arg(long, alias = "least-pull-mm", value_name = "MM", value_parser = crate::shared::number::distance_mm))]
    pub co_contraction_min_mm: Option<f64>,
    /// What the weights are kept as where the controller commands: int16 is faster where they do not fit a core's
    /// own cache (from a megabyte on); what it changes of the strokes is measured and reported; recurrent only
    #[cfg_attr(feature = "clap", arg(long, value_enum, default_value_t = Weights::Float32))]
    pub weights: Weights,
    /// Folder for report.html and metrics.json [default: OUT without its ending]
    #[cfg_attr(feature = "clap", arg(long, value_name = "DIR"))]
    pub figures: Option<PathBuf>,
    /// Numbers of the published network.
    #[cfg_attr(feature = "clap", command(flatten))]
    pub paper: PaperDesign,
    /// Seed of weights, order, noise and held-out recordings
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value_t = 1))]
    pub seed: u64,
}

/// What the weights are kept as.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum Weights {
    /// As they were trained
    Float32,
    /// Whole numbers in 16 bits, an 8191th of the largest of their row; inputs of products too
    Int16,
}

/// Carries out the verb.
pub fn run(options: &Options, context: &Context) -> anyhow::Result<Value> {
    paths::check_checkpoint(&options.out)?;
    if options.design == DesignName::Paper && options.co_contraction_min_mm.is_some() {
        return Err(BadInput::new("--co-contraction-min-mm", "the recurrent design", "the paper's").into());
    }
    if options.design == DesignName::Paper && options.weights != Weights::Float32 {
        return Err(BadInput::new("--weights", "the recurrent design", "the paper's").into());
    }
    let inputs = inputs::read(&options.recordings)?;
    let outputs = Outputs::reading(inputs.iter().map(|input| &input.path));
    let figures = paths::beside(&options.out, options.figures.as_deref());
    let outputs = outputs.file("--out", &options.out).report("--figures", Some(&figures));
    let _claim = outputs.check(context)?;
    let findings = recording_checks::of_inputs(&inputs, &CheckContext::new(Purpose::Fit))?;
    let data = dataset(options, &inputs, context)?;
    context.listen();
    let unfinished = Unfinished::new(&options.out, vec![options.out.with_extension("training")]);
    let mut display = Display { bar: None, context };
    let mut progress = |progress: &TrainingProgress| display.show(progress);
    let file = unfinished.files.first().map(PathBuf::as_path);
    let mut session = TrainingSession { file, progress: &mut progress };
    let fitted = match options.design {
        DesignName::Recurrent => fit_recurrent(&data, &recurrent(options), &mut session),
        DesignName::Paper => {
            let Options { epochs, hidden, seed, .. } = *options;
            fit_windowed(&data, &options.paper.options(PUBLISHED, [epochs, hidden], seed), &mut session)
        }
    };
    display.end();
    let mut fitted = fitted?;
    context.sign(&mut fitted.model.training);
    fitted.model.write(&options.out)?;
    let value = report(options, &data, &fitted, &findings, context)?;
    unfinished.end(fitted.is_finished, context)?;
    Ok(value)
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
        "learns from: {} real and {} synthetic recordings, {} samples; {left_out} left out by their role",
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
struct Display<'a> {
    bar: Option<Box<dyn crate::Progress>>,
    context: &'a Context<'a>,
}

impl Display<'_> {
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

/// Prints how well it does, and writes its report.
fn report(
    options: &Options,
    data: &Dataset,
    fitted: &FittedController,
    findings: &Findings,
    context: &Context,
) -> anyhow::Result<Value> {
    let report = &fitted.report;
    let line = |what: &str, errors: &[f64]| {
        let Some((network, baselines)) = errors.split_last() else { return };
        let baselines =
            report.methods.iter().zip(baselines).map(|(name, error)| format!("{name} {error:.4} mm"));
        let baselines: Vec<String> = baselines.collect();
        context.print(format_args!("{what} in validation: {network:.4} mm, {}", baselines.join(", ")));
    };
    report.channels.iter().for_each(|channel| line(&channel.name, &channel.errors));
    line("all strokes", &report.together());
    let mut warnings = training::losses(std::slice::from_ref(report));
    for (kind, names) in data.unvalidated() {
        let names = names.join(", ");
        warnings.push(format!("motion of kind {kind} is learned from and validated on nowhere: {names}"));
    }
    warnings.iter().for_each(|warning| tracing::warn!("{warning}"));
    let said = &fitted.model.training;
    let mut facts =
        vec![("Delay of the tip behind the strokes [ms]", format!("{:.0}", 1e3 * number(&said["delay_s"])))];
    if let Some(rms) = said["weights"]["stroke_rmse_mm"].as_f64() {
        let largest = number(&said["weights"]["stroke_largest_mm"]);
        facts.push((
            "What 16-bit weights change of the strokes in validation, rms and largest [mm]",
            format!("{rms:.1e}, {largest:.1e}"),
        ));
    }
    if let Some(error) = said["gradient_floor_relative_error"].as_f64() {
        facts.push((
            "What the floor of derivatives takes from the gradient, over its length",
            format!("{error:.1e}"),
        ));
    }
    let told = Told {
        title: "Inverse controller",
        about: format!(
            "From the path of a tip to strokes: {} recordings to learn from, {} to validate on and stop by.",
            report.training.len(),
            report.validation.len()
        ),
        reports: std::slice::from_ref(report),
        training: said,
        facts,
        warnings: &warnings,
        findings,
    };
    training::write(&paths::beside(&options.out, options.figures.as_deref()), &told, context)
}

fn number(value: &serde_json::Value) -> f64 {
    value.as_f64().unwrap_or(f64::NAN)
}
