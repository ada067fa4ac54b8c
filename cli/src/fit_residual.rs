//! `hysteron fit-residual`: the network that makes the twin show the robot's hysteresis.

use std::path::{Path, PathBuf};
use std::time::Instant;

use hysteron_base::{BadInput, Recording, rng};
use hysteron_control::split::{MotionKind, draw_validation};
use hysteron_learn::{Epoch, FitReport, MOST_EPOCHS, MOST_HIDDEN, Progress};
use hysteron_twin::residual::{
    Fitted, PUBLISHED, ResidualModel, Sequence, Sessions, StatefulOptions, fit_stateful, fit_windowed,
};
use serde_json::json;

use crate::figures::training::{self, Told};
use crate::inputs::{self, Input};
use crate::outputs::Outputs;
use crate::paper_design::PaperDesign;
use crate::unfinished::Unfinished;
use crate::{interrupt, number, paths, terminal};

const HELP: &str = "\
Needs recordings by hysteron identify (folders of them), at least two: the network learns from some and stops when it \
gets no better on the others, whole trajectories that it never sees in training. Recordings of a plan that are not \
for training (ellipses to check with, paths out of range) are left out.

Two designs. stateful, the default, goes through whole trajectories with one cell update a sample; it sees strokes \
through plays and lags, gives the tip displacement that is missing, and is fitted at the tip through the linearised \
twin; three are trained, each stopped by other recordings, and their mean is taken. A second network, from what hysteron \
identify --residual writes with the first, does better: linearised where a network leads the twin, little is left to \
extrapolate. paper is the published one: windows of 100 samples, 2 x 128 units, all virtual strokes as outputs.

Writes a checkpoint for `hysteron simulate --residual`: weights, ranges, design, which recordings were used and how \
well it did; report.html and metrics.json, in a folder beside it, have the learning curves and the error of every axis beside \
those of the twin alone and of the linear part. Warns where a network does no better. Ctrl-C ends the training and writes the best weights so far; the same command then goes on from OUT.training-1, ..., one \
for each network, and comes to what it would have come to without the interruption (not with --feedback).

Examples, from the root of the repository:
  hysteron identify meshes/tpu80/scene-typical.toml out/quick --out out/quick/identified
  hysteron fit-residual out/quick/identified --out out/quick/first.safetensors
  hysteron identify meshes/tpu80/scene-typical.toml out/quick \\
      --residual out/quick/first.safetensors --out out/quick/again
  hysteron fit-residual out/quick/again --out out/quick/residual.safetensors

Exit codes: 0 done, 1 failed or interrupted, 2 bad input.";

/// More networks than any mean gains from.
pub const MOST_MEMBERS: usize = 32;

/// Train the residual network on identified recordings (CoReAct)
#[derive(Debug, clap::Args)]
#[command(after_help = HELP)]
pub struct Arguments {
    /// Folders written by hysteron identify, or recordings in them
    #[arg(required = true, value_name = "DIR")]
    recordings: Vec<PathBuf>,
    /// Checkpoint to write, .safetensors
    #[arg(long, value_name = "CKPT")]
    out: PathBuf,
    /// Which network
    #[arg(long, value_enum, default_value_t = DesignName::Stateful)]
    design: DesignName,
    /// Recordings to stop by, by name [default: for each network, a sixth of every kind of motion and at least one of each that has
    /// two, drawn by the seed; a kind is the family of the plan, or what the strokes tell]
    #[arg(long, value_name = "NAME,...", value_delimiter = ',')]
    held_out: Vec<String>,
    /// Epochs at most [default: 100; paper: 30]
    #[arg(long, value_name = "N", value_parser = number::count::<MOST_EPOCHS>)]
    epochs: Option<usize>,
    /// Hidden units of a layer [default: 64; paper: 128]
    #[arg(long, value_name = "N", value_parser = number::count::<MOST_HIDDEN>)]
    hidden: Option<usize>,
    /// Networks whose mean is taken, each stopped by other recordings; the paper's design has one
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = number::count::<MOST_MEMBERS>)]
    members: usize,
    /// Let the network see the twin's tip of the sample before (eq. 11), not the strokes alone
    #[arg(long)]
    feedback: bool,
    /// Folder for report.html and metrics.json [default: OUT without its ending]
    #[arg(long, value_name = "DIR")]
    figures: Option<PathBuf>,
    #[command(flatten)]
    paper: PaperDesign,
    /// Seed of weights, order and held-out recordings
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
    let inputs = inputs::read(&arguments.recordings)?;
    let scene_hash = common_scene(&inputs)?;
    let outputs = Outputs::reading(inputs.iter().map(|input| &input.path));
    let _claim = outputs.file("--out", &arguments.out).check()?;
    let usable: Vec<&Input> = inputs
        .iter()
        .filter(|input| matches!(inputs::role(input.recording.meta()), "" | "training"))
        .collect();
    let members = match arguments.design {
        DesignName::Stateful => arguments.members,
        DesignName::Paper => 1,
    };
    let held_out =
        (0..members).map(|member| held_out(arguments, &usable, member)).collect::<Result<Vec<_>, _>>()?;
    let sequences = usable.iter().map(|input| sequence(input)).collect::<anyhow::Result<Vec<_>>>()?;
    let samples = sequences.iter().map(Sequence::len).sum::<usize>();
    tracing::info!("{} recordings, {samples} samples", sequences.len());
    for held_out in &held_out {
        let names: Vec<&str> = held_out.iter().map(|&k| usable[k].name.as_str()).collect();
        terminal::say(format_args!("a network is validated on: {}", names.join(", ")));
    }
    interrupt::listen()?;
    // What a network with feedback has seen of itself is in no file.
    let n_files = if arguments.feedback { 0 } else { members };
    let files = (1..=n_files).map(|k| arguments.out.with_extension(format!("training-{k}"))).collect();
    let unfinished = Unfinished::new(&arguments.out, files);
    let display = Display::default();
    let progress = |number: usize, report: &Progress| display.show(number, report);
    let sessions = Sessions { files: unfinished.files.clone(), progress: &progress };
    let fitted = fit(arguments, &sequences, &held_out, &scene_hash, &display, &sessions);
    display.bar.finish_and_clear();
    let Fitted { mut model, reports, is_finished } = fitted?;
    model.training["command"] = json!(terminal::command_line());
    model.training["commit"] = json!(env!("HYSTERON_COMMIT"));
    model.training["version"] = json!(env!("CARGO_PKG_VERSION"));
    model.write(&arguments.out)?;
    report(arguments, &model, &reports)?;
    unfinished.end(is_finished)
}

/// Prints how well the networks do, and writes their report.
fn report(arguments: &Arguments, model: &ResidualModel, reports: &[FitReport]) -> anyhow::Result<()> {
    for (k, report) in reports.iter().enumerate() {
        let of_method = report.methods.iter().zip(report.together());
        let errors: Vec<String> = of_method.map(|(name, error)| format!("{name} {error:.3} mm")).collect();
        terminal::say(format_args!("network {} in validation: {}", k + 1, errors.join(", ")));
    }
    let warnings = training::losses(reports);
    warnings.iter().for_each(|warning| tracing::warn!("{warning}"));
    let floor = model.training["gradient_floor_relative_error"].as_f64();
    let floor = floor.map(|error| {
        ("What the floor of derivatives takes from the gradient, over its length", format!("{error:.1e}"))
    });
    let told = Told {
        title: "Residual network",
        about: format!(
            "What the twin misses of the robot, learned from identified recordings; {} networks, of which the mean is taken. \
             Errors are those of the tip through the linearised twin, root mean square.",
            reports.len()
        ),
        reports,
        training: &model.training,
        facts: floor.into_iter().collect(),
        warnings: &warnings,
    };
    training::write(&paths::beside(&arguments.out, arguments.figures.as_deref()), &told)
}

fn fit(
    arguments: &Arguments,
    sequences: &[Sequence],
    held_out: &[Vec<usize>],
    scene_hash: &str,
    display: &Display,
    sessions: &Sessions<'_>,
) -> hysteron_twin::Result<Fitted> {
    let Arguments { epochs, hidden, seed, .. } = *arguments;
    match arguments.design {
        DesignName::Stateful => {
            let default = StatefulOptions::default();
            let options = StatefulOptions {
                learning: default.learning.with([epochs, hidden]),
                feedback: arguments.feedback,
                seed,
                ..default
            };
            display.bar.set_length((held_out.len() * options.learning.epochs) as u64);
            fit_stateful(sequences, held_out, scene_hash, &options, sessions)
        }
        DesignName::Paper => {
            let options = arguments.paper.options(PUBLISHED, [epochs, hidden], seed);
            display.bar.set_length(options.epochs as u64);
            let is_held = |k: &usize| held_out[0].contains(k);
            let (held, seen): (Vec<usize>, Vec<usize>) = (0..sequences.len()).partition(is_held);
            let pick = |indices: Vec<usize>| -> Vec<Sequence> {
                indices.into_iter().map(|k| sequences[k].clone()).collect()
            };
            fit_windowed(&pick(seen), &pick(held), scene_hash, &options, sessions)
        }
    }
}

/// A bar over the epochs of all networks.
struct Display {
    bar: terminal::Progress,
    start: Instant,
}

impl Default for Display {
    fn default() -> Self {
        Self { bar: terminal::progress("epochs", 0, 0), start: Instant::now() }
    }
}

impl Display {
    /// False where the training is to end.
    fn show(&self, member: usize, progress: &Progress) -> bool {
        if let Progress::Epoch(Epoch { number, of, training, held_out, best }) = progress {
            self.bar.inc(1);
            self.bar.set_message(format!("held out {best:.3} mm"));
            tracing::debug!(
                "network {}, epoch {number}/{of}: {training:.3} mm, held out {held_out:.3} mm, best {best:.3} mm; {:.0} s",
                member + 1,
                self.start.elapsed().as_secs_f64(),
            );
        }
        !interrupt::is_asked()
    }
}

/// The scene that all recordings were identified with.
fn common_scene(inputs: &[Input]) -> Result<String, BadInput> {
    let hash = |input: &Input| input.recording.meta().scene_hash.clone();
    let first = hash(&inputs[0]);
    match inputs.iter().find(|input| hash(input) != first) {
        None if first.is_empty() => {
            let place = format!("{}: scene_hash", inputs[0].path.display());
            Err(BadInput::new(place, "a recording by hysteron identify", "nothing")
                .hint("identify the recordings of the robot first"))
        }
        None => Ok(first),
        Some(other) => Err(BadInput::new(
            format!("{}: scene_hash", other.path.display()),
            format!("{first}, as {}", inputs[0].path.display()),
            hash(other),
        )
        .hint("identify all recordings with one scene")),
    }
}

/// The recordings that a network stops by, as indices.
fn held_out(arguments: &Arguments, usable: &[&Input], member: usize) -> Result<Vec<usize>, BadInput> {
    let names: Vec<&str> = usable.iter().map(|input| input.name.as_str()).collect();
    if names.len() < 2 {
        let found = format!("{} for training", names.len());
        return Err(BadInput::new("recordings", "at least two", found)
            .hint("the network must stop by a trajectory that it does not learn from"));
    }
    if let Some(unknown) = arguments.held_out.iter().find(|name| !names.contains(&name.as_str())) {
        return Err(BadInput::new("--held-out", format!("of {}", names.join(", ")), unknown.clone()));
    }
    if !arguments.held_out.is_empty() {
        return Ok((0..names.len()).filter(|&k| arguments.held_out.contains(&usable[k].name)).collect());
    }
    let mut stream = rng(arguments.seed, &format!("residual/held-out/{member}"));
    let kinds: Vec<String> = usable.iter().map(|input| kind(&input.recording)).collect();
    Ok(draw_validation(&kinds, &mut stream))
}

/// Kind of the motion: the family of its plan, or where it has none what its strokes tell.
fn kind(recording: &Recording) -> String {
    if let Some(family) = recording.meta().extra.get("plan.family") {
        return family.clone();
    }
    let strokes = recording.strokes();
    let rows: Vec<f64> = (0..recording.n_samples()).flat_map(|i| strokes.iter().map(move |s| s[i])).collect();
    MotionKind::of(&rows, strokes.len()).name().to_owned()
}

fn sequence(input: &Input) -> anyhow::Result<Sequence> {
    let beside =
        |path: &Path| -> Option<PathBuf> { Some(path.parent()?.join("sensitivity").join(path.file_name()?)) };
    let path = beside(&input.path).unwrap_or_default();
    if !path.exists() {
        return Err(BadInput::new(
            path.display().to_string(),
            "what hysteron identify wrote beside the recording",
            "nothing",
        )
        .hint("identify the recordings of the robot first")
        .into());
    }
    let sensitivity = Recording::read(&path)?;
    let origin = |recording: &Recording| {
        let keys = ["identify.input_sha256", "identify.options"];
        let extra = keys.map(|key| recording.meta().extra.get(key).cloned());
        (recording.meta().scene_hash.clone(), extra)
    };
    if origin(&sensitivity) != origin(&input.recording) {
        let expected = format!("what was identified together with {}", input.path.display());
        return Err(BadInput::new(
            path.display().to_string(),
            expected,
            "of another scene, recording or options",
        )
        .hint("run hysteron identify again")
        .into());
    }
    Ok(Sequence::new(&input.path.display().to_string(), &input.recording, &sensitivity)?)
}
