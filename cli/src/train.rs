//! `hysteron train`: the inverse controller, from recordings of a rig and of a twin.

use std::path::PathBuf;

use hysteron_base::BadInput;
use hysteron_control::inverse::{
    Axes, Dataset, Demonstration, Fitted, LossWeights, Origin, PUBLISHED, StatefulOptions, fit_stateful,
    fit_windowed,
};
use hysteron_learn::{Epoch, MOST_EPOCHS, MOST_HIDDEN, Progress, Session, WeightFormat};
use serde_json::json;

use crate::figures::training::{self, Told};
use crate::inputs::{self, Input};
use crate::outputs::Outputs;
use crate::paper_design::PaperDesign;
use crate::unfinished::Unfinished;
use crate::{interrupt, number, paths, terminal};

const HELP: &str = "\
Needs recordings (files, or folders of them) with the tip, tip_x_m and tip_y_m (with --spatial tip_z_m too), and the strokes that made it, stroke_1_m, \
..., all of one robot and at one rate: of a rig (`hysteron record`), of a twin (`hysteron simulate`), or both. The network \
learns from some and stops when it gets no better on the others, whole trajectories that it never sees in training. \
Recordings of a plan that are not for training (ellipses to check with, paths out of range) are left out.

Two designs. stateful, the default, goes through whole trajectories with one cell update a sample; it sees position, \
rate and direction of the path, now and a little ahead, and corrects a static regression. paper is the published one: \
windows of 200 samples of x and y, 2 x 512 units, all strokes as outputs.

Writes a checkpoint for `hysteron command`: weights, ranges, design, which recordings were used and how well it did. \
Prints which recordings it is validated on, and the error of every stroke there beside that of static regressions (one reads \
the path as much ahead as the tip is found to come after the strokes); warns where the network does no better. report.html and \
metrics.json, in a folder beside the checkpoint, have them too, with the learning curve. Ctrl-C ends \
the training and writes the best weights so far; the same command then goes on from OUT.training, and comes to what it \
would have come to without the interruption.

Examples, from the root of the repository:
  hysteron record --rig virtual:typical --plan quick --out out/quick
  hysteron train out/quick --out out/quick/inverse.safetensors
  hysteron train out/quick --design paper --stride 20 --held-out circle \\
      --out out/quick/paper.safetensors

Exit codes: 0 done, 1 failed or interrupted, 2 bad input.";

/// Train the inverse controller on recordings (EDIC)
#[derive(Debug, clap::Args)]
#[command(after_help = HELP)]
pub struct Arguments {
    /// Recordings, or folders of them
    #[arg(required = true, value_name = "REC")]
    recordings: Vec<PathBuf>,
    /// Checkpoint to write, .safetensors
    #[arg(long, value_name = "CKPT")]
    out: PathBuf,
    /// Which network
    #[arg(long, value_enum, default_value_t = DesignName::Stateful)]
    design: DesignName,
    /// Where the tip shall be in x, y and z, for a robot of several segments; else in x and y
    #[arg(long)]
    spatial: bool,
    /// A recording to validate on and stop by, by name; may be given several times [default: a sixth of every kind of motion and
    /// at least one of each that has two, drawn by the seed; a kind is the family of the plan, or what the strokes tell]
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    held_out: Vec<String>,
    /// Epochs at most [default: 30]
    #[arg(long, value_name = "N", value_parser = number::count::<MOST_EPOCHS>)]
    epochs: Option<usize>,
    /// Hidden units of a layer [default: 128; paper: 512]
    #[arg(long, value_name = "N", value_parser = number::count::<MOST_HIDDEN>)]
    hidden: Option<usize>,
    /// Pull that all tendons are to have in common at the least, so that none goes slack; stateful only
    #[arg(long, value_name = "MM", value_parser = number::distance_mm)]
    least_pull_mm: Option<f64>,
    /// What the weights are kept as where the controller commands: int16 is faster where they do not fit a core's own cache (from
    /// a megabyte on); what it changes of the strokes is measured and reported; stateful only
    #[arg(long, value_enum, default_value_t = Weights::Float32)]
    weights: Weights,
    /// Folder for report.html and metrics.json [default: OUT without its ending]
    #[arg(long, value_name = "DIR")]
    figures: Option<PathBuf>,
    #[command(flatten)]
    paper: PaperDesign,
    /// Seed of weights, order, noise and held-out recordings
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum DesignName {
    /// One cell update a sample
    Stateful,
    /// As published
    Paper,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Weights {
    /// As they were trained
    Float32,
    /// Whole numbers of 16 bits in the unit of their row
    Int16,
}

/// Carries out the verb.
pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    paths::check_checkpoint(&arguments.out)?;
    if arguments.design == DesignName::Paper && arguments.least_pull_mm.is_some() {
        return Err(BadInput::new("--least-pull-mm", "the stateful design", "the paper's").into());
    }
    if arguments.design == DesignName::Paper && arguments.weights != Weights::Float32 {
        return Err(BadInput::new("--weights", "the stateful design", "the paper's").into());
    }
    let inputs = inputs::read(&arguments.recordings)?;
    let outputs = Outputs::reading(inputs.iter().map(|input| &input.path));
    let _claim = outputs.file("--out", &arguments.out).check()?;
    let data = dataset(arguments, &inputs)?;
    interrupt::listen()?;
    let unfinished = Unfinished::new(&arguments.out, vec![arguments.out.with_extension("training")]);
    let mut display = Display::default();
    let mut progress = |progress: &Progress| display.show(progress);
    let file = unfinished.files.first().map(PathBuf::as_path);
    let mut session = Session { file, progress: &mut progress };
    let fitted = match arguments.design {
        DesignName::Stateful => fit_stateful(&data, &stateful(arguments), &mut session),
        DesignName::Paper => {
            let Arguments { epochs, hidden, seed, .. } = *arguments;
            fit_windowed(&data, &arguments.paper.options(PUBLISHED, [epochs, hidden], seed), &mut session)
        }
    };
    display.end();
    let mut fitted = fitted?;
    fitted.model.training["command"] = json!(terminal::command_line());
    fitted.model.training["commit"] = json!(env!("HYSTERON_COMMIT"));
    fitted.model.training["version"] = json!(env!("CARGO_PKG_VERSION"));
    fitted.model.write(&arguments.out)?;
    report(arguments, &data, &fitted)?;
    unfinished.end(fitted.is_finished)
}

fn dataset(arguments: &Arguments, inputs: &[Input]) -> anyhow::Result<Dataset> {
    let axes = if arguments.spatial { Axes::Spatial } else { Axes::Planar };
    let usable =
        inputs.iter().filter(|input| matches!(inputs::role(input.recording.meta()), "" | "training"));
    let demonstrations = usable.map(|input| {
        Demonstration::new(&input.name, &input.hash, &input.recording, axes)
            .map_err(|bad| bad.within(input.path.display()))
    });
    let all = demonstrations.collect::<Result<Vec<_>, BadInput>>()?;
    let left_out = inputs.len() - all.len();
    let data = Dataset::new(all, &arguments.held_out, arguments.seed)?;
    let names: Vec<String> =
        data.validation.iter().map(|one| format!("{} ({})", one.name, one.kind())).collect();
    terminal::say(format_args!("validated on: {}", names.join(", ")));
    terminal::say(format_args!(
        "learns from: {} real and {} synthetic recordings, {} samples; {left_out} left out by their role",
        data.count(Origin::Real),
        data.count(Origin::Synthetic),
        data.training.iter().map(Demonstration::len).sum::<usize>(),
    ));
    Ok(data)
}

fn stateful(arguments: &Arguments) -> StatefulOptions {
    let default = StatefulOptions::default();
    let least_pull_m = arguments.least_pull_mm.map_or(default.loss.least_pull_m, |mm| 1e-3 * mm);
    StatefulOptions {
        learning: default.learning.with([arguments.epochs, arguments.hidden]),
        loss: LossWeights { least_pull_m, ..default.loss },
        weights: match arguments.weights {
            Weights::Float32 => WeightFormat::Float32,
            Weights::Int16 => WeightFormat::Int16,
        },
        seed: arguments.seed,
        ..default
    }
}

/// A bar of all steps of the epoch, and a line per epoch.
#[derive(Default)]
struct Display {
    bar: Option<terminal::Progress>,
}

impl Display {
    /// False once the person has asked to stop.
    fn show(&mut self, progress: &Progress) -> bool {
        match progress {
            Progress::Step { done, of, .. } => {
                let bar = self.bar.get_or_insert_with(|| terminal::progress("steps of the epoch", *of, 0));
                bar.set_position(*done as u64);
            }
            Progress::Epoch(Epoch { number, of, training, held_out, best }) => {
                self.end();
                tracing::info!(
                    "epoch {number}/{of}: {training:.3} mm, held out {held_out:.3} mm, best {best:.3} mm"
                );
            }
        }
        !interrupt::is_asked()
    }

    fn end(&mut self) {
        if let Some(bar) = self.bar.take() {
            bar.finish_and_clear();
        }
    }
}

/// Prints how well it does, and writes its report.
fn report(arguments: &Arguments, data: &Dataset, fitted: &Fitted) -> anyhow::Result<()> {
    let report = &fitted.report;
    let line = |what: &str, errors: &[f64]| {
        let Some((network, baselines)) = errors.split_last() else { return };
        let baselines =
            report.methods.iter().zip(baselines).map(|(name, error)| format!("{name} {error:.4} mm"));
        let baselines: Vec<String> = baselines.collect();
        terminal::say(format_args!("{what} in validation: {network:.4} mm, {}", baselines.join(", ")));
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
    };
    training::write(&paths::beside(&arguments.out, arguments.figures.as_deref()), &told)
}

fn number(value: &serde_json::Value) -> f64 {
    value.as_f64().unwrap_or(f64::NAN)
}
