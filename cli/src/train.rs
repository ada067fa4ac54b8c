//! `hysteron train`: the inverse controller, from recordings of a rig and of a twin.

use std::path::PathBuf;

use hysteron_base::BadInput;
use hysteron_control::inverse::{
    Axes, Dataset, Demonstration, Fitted, LossWeights, Origin, PUBLISHED, StatefulOptions, fit_stateful,
    fit_windowed,
};
use hysteron_learn::{Epoch, Progress, Session};
use indicatif::ProgressBar;
use serde_json::json;

use crate::paper_design::PaperDesign;
use crate::unfinished::Unfinished;
use crate::{inputs, interrupt, paths, terminal};

const HELP: &str = "\
Needs recordings (files, or folders of them) with the tip, tip_x_m and tip_y_m (with --spatial tip_z_m too), and the strokes that made it, stroke_1_m, \
..., all of one robot and at one rate: of a rig (`hysteron record`), of a twin (`hysteron simulate`), or both. The network \
learns from some and stops when it gets no better on the others, whole trajectories that it never sees in training. \
Recordings of a plan that are not for training (ellipses to check with, paths out of range) are left out.

Two designs. stateful, the default, goes through whole trajectories with one cell update a sample; it sees position, \
rate and direction of the path, now and a little ahead, and corrects a static regression. paper is the published one: \
windows of 200 samples of x and y, 2 x 512 units, all strokes as outputs.

Writes a checkpoint for `hysteron command`: weights, ranges, design, which recordings were used and how well it did. \
Prints the error of every stroke on the trajectories held out, beside that of the static regression alone. Ctrl-C ends \
the training and writes the best weights so far; the same command then goes on from OUT.training, and comes to what it \
would have come to without the interruption.

Examples, from the root of the repository:
  hysteron record --rig virtual:typical --plan quick --out out/quick
  hysteron train out/quick --out out/quick/inverse.safetensors
  hysteron train out/quick --design paper --stride 20 --held-out circle --out out/quick/paper.safetensors

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
    /// A recording to stop by, by name; may be given several times [default: one of every family, drawn by the seed]
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    held_out: Vec<String>,
    /// Epochs at most [default: 30]
    #[arg(long, value_name = "N")]
    epochs: Option<usize>,
    /// Hidden units of a layer [default: 128; paper: 512]
    #[arg(long, value_name = "N")]
    hidden: Option<usize>,
    /// Pull that all tendons are to have in common at the least, so that none goes slack; stateful only
    #[arg(long, value_name = "MM")]
    least_pull_mm: Option<f64>,
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

/// Carries out the verb.
pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    paths::check_checkpoint(&arguments.out)?;
    if arguments.design == DesignName::Paper && arguments.least_pull_mm.is_some() {
        return Err(BadInput::new("--least-pull-mm", "the stateful design", "the paper's").into());
    }
    let data = dataset(arguments)?;
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
    report(&fitted);
    unfinished.end(fitted.is_finished)
}

fn dataset(arguments: &Arguments) -> anyhow::Result<Dataset> {
    let inputs = inputs::read(&arguments.recordings)?;
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
    let names: Vec<&str> = data.validation.iter().map(|one| one.name.as_str()).collect();
    tracing::info!(
        "{} real and {} synthetic recordings to learn from, {} samples; {} to stop by: {}; {left_out} left out by their \
         role",
        data.count(Origin::Real),
        data.count(Origin::Synthetic),
        data.training.iter().map(Demonstration::len).sum::<usize>(),
        names.len(),
        names.join(", "),
    );
    Ok(data)
}

fn stateful(arguments: &Arguments) -> StatefulOptions {
    let default = StatefulOptions::default();
    let least_pull_m = arguments.least_pull_mm.map_or(default.loss.least_pull_m, |mm| 1e-3 * mm);
    StatefulOptions {
        learning: default.learning.with([arguments.epochs, arguments.hidden]),
        loss: LossWeights { least_pull_m, ..default.loss },
        seed: arguments.seed,
        ..default
    }
}

/// A bar of all steps of the epoch, and a line per epoch.
#[derive(Default)]
struct Display {
    bar: Option<ProgressBar>,
}

impl Display {
    /// False once the person has asked to stop.
    fn show(&mut self, progress: &Progress) -> bool {
        match progress {
            Progress::Step { done, of, .. } => {
                let bar = self.bar.get_or_insert_with(|| terminal::progress("steps of the epoch", *of, 0));
                bar.set_position(*done as u64);
            }
            Progress::Epoch(Epoch { number, training, held_out, best }) => {
                self.end();
                tracing::info!(
                    "epoch {number}: {training:.3} mm, held out {held_out:.3} mm, best {best:.3} mm"
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

/// Prints how well it does.
fn report(fitted: &Fitted) {
    let root_mean = |values: &[f64]| (values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64).sqrt();
    let line = |what: String, found: f64, regression: f64| {
        terminal::say(format!("{what}: {found:.4} mm, static regression {regression:.4} mm"));
    };
    for (k, (found, regression)) in fitted.held_out_mm.iter().zip(&fitted.regression_mm).enumerate() {
        line(format!("stroke {} held out", k + 1), *found, *regression);
    }
    line("all strokes held out".to_owned(), root_mean(&fitted.held_out_mm), root_mean(&fitted.regression_mm));
}
