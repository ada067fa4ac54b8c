//! `hysteron fit-residual`: the network that makes the twin show the robot's hysteresis.

use std::path::{Path, PathBuf};
use std::time::Instant;

use hysteron_base::{BadInput, Recording, rng};
use hysteron_twin::residual::{
    Epoch, ResidualModel, Sequence, StatefulOptions, WindowedOptions, fit_stateful, fit_windowed,
};
use rand::seq::IndexedRandom;

use crate::inputs::{self, Input};
use crate::{interrupt, terminal};

const HELP: &str = "\
Needs recordings by hysteron identify (folders of them), at least two: the network learns from some and stops when it \
gets no better on the others, whole trajectories that it never sees in training. Recordings of a plan that are not \
for training (ellipses to check with, paths out of range) are left out.

Two designs. stateful, the default, goes through whole trajectories with one cell update a sample; it sees strokes \
through plays and lags, gives the tip displacement that is missing, and is fitted at the tip through the linearised \
twin. paper is the published one: windows of 100 samples, 2 x 128 units, all virtual strokes as outputs.

Writes a checkpoint for `hysteron simulate --residual`: weights, ranges, design, which recordings were used and how \
well it did. Ctrl-C ends the training and keeps the best weights so far.

Examples, from the root of the repository:
  hysteron identify meshes/tpu80/scene-coreact.toml out/quick --out out/quick/identified
  hysteron fit-residual out/quick/identified --out out/quick/residual.safetensors

Exit codes: 0 done, 1 failed, 2 bad input.";

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
    /// Recordings to stop by, by name [default: one of every family, drawn by the seed]
    #[arg(long, value_name = "NAME,...", value_delimiter = ',')]
    held_out: Vec<String>,
    /// Epochs at most [default: 150; paper: 30]
    #[arg(long, value_name = "N")]
    epochs: Option<usize>,
    /// Hidden units of a layer [default: 64; paper: 128]
    #[arg(long, value_name = "N")]
    hidden: Option<usize>,
    /// Let the network see the twin's tip of the sample before (eq. 11), not the strokes alone
    #[arg(long)]
    feedback: bool,
    /// Only every Nth window of the paper's design; 1 is published
    #[arg(long, value_name = "N", default_value_t = 1)]
    stride: usize,
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
    if arguments.out.extension().is_none_or(|ending| ending != "safetensors") {
        let found = arguments.out.display().to_string();
        return Err(BadInput::new("--out", "a name ending in .safetensors", found).into());
    }
    let inputs = inputs::read(&arguments.recordings)?;
    let scene_hash = common_scene(&inputs)?;
    let usable: Vec<&Input> = inputs
        .iter()
        .filter(|input| matches!(inputs::role(input.recording.meta()), "" | "training"))
        .collect();
    let held_out = held_out(arguments, &usable)?;
    let (held, seen): (Vec<&Input>, Vec<&Input>) =
        usable.into_iter().partition(|input| held_out.contains(&input.name));
    let sequences =
        |inputs: &[&Input]| inputs.iter().map(|input| sequence(input)).collect::<anyhow::Result<Vec<_>>>();
    let (training, held) = (sequences(&seen)?, sequences(&held)?);
    tracing::info!(
        "{} recordings to learn from, {} samples; {} to stop by: {}",
        training.len(),
        training.iter().map(Sequence::len).sum::<usize>(),
        held.len(),
        held_out.join(", "),
    );
    interrupt::listen()?;
    let start = Instant::now();
    let mut on_epoch = |epoch: &Epoch| {
        tracing::info!(
            "epoch {}: {:.3} mm, held out {:.3} mm, best {:.3} mm; {:.0} s",
            epoch.number,
            epoch.training_mm,
            epoch.held_out_mm,
            epoch.best_mm,
            start.elapsed().as_secs_f64(),
        );
        !interrupt::is_asked()
    };
    let model: ResidualModel = match arguments.design {
        DesignName::Stateful => {
            let default = StatefulOptions::default();
            let options = StatefulOptions {
                epochs: arguments.epochs.unwrap_or(default.epochs),
                hidden: arguments.hidden.unwrap_or(default.hidden),
                feedback: arguments.feedback,
                seed: arguments.seed,
                ..default
            };
            fit_stateful(&training, &held, &scene_hash, &options, &mut on_epoch)?
        }
        DesignName::Paper => {
            let default = WindowedOptions::default();
            let options = WindowedOptions {
                epochs: arguments.epochs.unwrap_or(default.epochs),
                hidden: arguments.hidden.unwrap_or(default.hidden),
                stride: arguments.stride,
                seed: arguments.seed,
                ..default
            };
            fit_windowed(&training, &held, &scene_hash, &options, &mut on_epoch)?
        }
    };
    model.write(&arguments.out)?;
    terminal::say(arguments.out.display());
    Ok(())
}

/// The scene that all recordings were identified with.
fn common_scene(inputs: &[Input]) -> Result<String, BadInput> {
    let hash = |input: &Input| input.recording.meta().scene_hash.clone();
    let first = hash(&inputs[0]);
    match inputs.iter().find(|input| hash(input) != first) {
        None => Ok(first),
        Some(other) => Err(BadInput::new(
            format!("{}: scene_hash", other.path.display()),
            format!("{first}, as {}", inputs[0].path.display()),
            hash(other),
        )
        .hint("identify all recordings with one scene")),
    }
}

/// Names of the recordings to stop by.
fn held_out(arguments: &Arguments, usable: &[&Input]) -> Result<Vec<String>, BadInput> {
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
        return Ok(arguments.held_out.clone());
    }
    let family = |input: &Input| input.recording.meta().extra.get("plan.family").cloned().unwrap_or_default();
    let mut families: Vec<String> = usable.iter().map(|input| family(input)).collect();
    families.sort();
    families.dedup();
    let mut stream = rng(arguments.seed, "residual/held-out");
    // A family of one is needed for training.
    let draw = |name: &String| {
        let members: Vec<&&Input> = usable.iter().filter(|input| family(input) == *name).collect();
        if members.len() < 2 { None } else { members.choose(&mut stream).map(|input| input.name.clone()) }
    };
    let drawn: Vec<String> = families.iter().filter_map(draw).collect();
    Ok(if drawn.is_empty() { vec![names[names.len() - 1].to_owned()] } else { drawn })
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
    Ok(Sequence::new(&input.path.display().to_string(), &input.recording, &Recording::read(&path)?)?)
}
