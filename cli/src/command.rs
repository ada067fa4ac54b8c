//! `hysteron command`: strokes for a path of the tip, by a trained inverse controller.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::bail;
use hysteron_base::{BadInput, Bounds, Channel, Metadata, Recording, file};
use hysteron_control::Limits;
use hysteron_control::inverse::{Commands, InverseModel};

use crate::{figures, interrupt, terminal};

const HELP: &str = "\
CKPT is by `hysteron train`. FILE is a recording (.parquet or .csv) with the path that the tip shall follow, tip_x_mm and \
tip_y_mm (or in m), at the rate of the training.

Writes a recording with a stroke for every tendon, the path as target_x_m and target_y_m, and extrapolating: 1 where \
the path leaves what was seen in training. Strokes stay within the range of the training and change no faster than \
there, or within the limits given; how many samples that held back is said at the end.

Examples, from the root of the repository:
  hysteron record --rig virtual:typical --plan quick --out out/quick
  hysteron train out/quick --out out/quick/inverse.safetensors
  hysteron command out/quick/inverse.safetensors --target out/quick/ellipse.parquet \\
      --out out/quick/commands.parquet --figures out/quick/commands

Exit codes: 0 done, 1 failed or interrupted, 2 bad input (nothing is written under the final name).";

/// Find the strokes that bring the tip along a path (EDIC)
#[derive(Debug, clap::Args)]
#[command(after_help = HELP)]
pub struct Arguments {
    /// Checkpoint by hysteron train
    #[arg(value_name = "CKPT")]
    checkpoint: PathBuf,
    /// Path that the tip shall follow
    #[arg(long, value_name = "FILE")]
    target: PathBuf,
    /// Recording to write, .parquet or .csv
    #[arg(long, value_name = "REC")]
    out: PathBuf,
    /// Smallest stroke [default: that of the training]
    #[arg(long, value_name = "MM", allow_negative_numbers = true)]
    stroke_min_mm: Option<f64>,
    /// Largest stroke [default: that of the training]
    #[arg(long, value_name = "MM", allow_negative_numbers = true)]
    stroke_max_mm: Option<f64>,
    /// Fastest change of a stroke [default: that of the training]
    #[arg(long, value_name = "MM/S")]
    stroke_rate_max_mm_s: Option<f64>,
    /// Folder for a figure of the strokes
    #[arg(long, value_name = "DIR")]
    figures: Option<PathBuf>,
}

/// Where the tip shall go.
struct Target {
    /// Times (n_samples) [s].
    time: Vec<f64>,
    /// Duration of a sample [s].
    step: f64,
    /// x and y (n_samples) [m].
    path: Vec<[f64; 2]>,
}

/// Carries out the verb.
pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let model = InverseModel::read(&arguments.checkpoint)?;
    let target = read_target(&arguments.target)?;
    model.check_step(target.step).map_err(|bad| bad.within(arguments.target.display()))?;
    interrupt::listen()?;
    let n = target.path.len();
    let bar = terminal::progress(n, 0);
    let mut progress = |done: usize| {
        bar.set_position(done as u64);
        !interrupt::is_asked()
    };
    let commands = model.command(&target.path, limits(&model, arguments), &mut progress)?;
    bar.finish_and_clear();
    if commands.steps.len() < n {
        bail!("interrupted after {} of {n} samples; nothing is written", commands.steps.len());
    }
    let limited = commands.steps.iter().filter(|step| step.is_limited).count();
    let extrapolating = commands.steps.iter().filter(|step| step.is_extrapolating).count();
    tracing::info!("{} network, {n} samples: {limited} held back by a limit", model.size());
    if extrapolating > 0 {
        tracing::warn!(
            "{:.1} % of the path is outside what was seen in training",
            100.0 * extrapolating as f64 / n as f64
        );
    }
    let recording = recording(arguments, &target, &commands, limited)?;
    recording.write(&arguments.out)?;
    if let Some(folder) = &arguments.figures {
        figures::commands::write(folder, &recording)?;
    }
    terminal::say(arguments.out.display());
    Ok(())
}

/// Reads the path that the tip shall follow: a recording with `tip_x_m` and `tip_y_m` at a fixed rate.
fn read_target(path: &Path) -> anyhow::Result<Target> {
    let recording = Recording::read(path)?;
    let within = |bad: BadInput| bad.within(path.display());
    let [x, y] = ["tip_x_m", "tip_y_m"].map(|name| recording.require(name).map_err(within));
    let (x, y) = (x?, y?);
    let rate = recording
        .rate_hz()
        .ok_or_else(|| within(BadInput::new("time_s", "a fixed rate", "uneven steps").hint("resample it")))?;
    let path = x.iter().zip(y).map(|(&x, &y)| [x, y]).collect();
    Ok(Target { time: recording.time().to_vec(), step: rate.recip(), path })
}

/// Those of the training, but for the ones given.
fn limits(model: &InverseModel, arguments: &Arguments) -> Limits {
    let given = |mm: Option<f64>, otherwise: f64| mm.map_or(otherwise, |mm| 1e-3 * mm);
    let Limits { stroke, stroke_rate } = model.limits;
    Limits {
        stroke: Bounds {
            min: given(arguments.stroke_min_mm, stroke.min),
            max: given(arguments.stroke_max_mm, stroke.max),
        },
        stroke_rate: given(arguments.stroke_rate_max_mm_s, stroke_rate),
    }
}

fn recording(
    arguments: &Arguments,
    target: &Target,
    commands: &Commands,
    limited: usize,
) -> anyhow::Result<Recording> {
    let n_tendons = commands.strokes.len() / target.path.len();
    let stroke = |k: usize| {
        let values = commands.strokes.iter().skip(k).step_by(n_tendons).copied().collect();
        Channel::new(format!("stroke_{}_m", k + 1), values)
    };
    let mut channels: Vec<Channel> = (0..n_tendons).map(stroke).collect();
    for (c, name) in ["target_x_m", "target_y_m"].into_iter().enumerate() {
        channels.push(Channel::new(name, target.path.iter().map(|point| point[c]).collect()));
    }
    let flags = commands.steps.iter().map(|step| f64::from(u8::from(step.is_extrapolating)));
    channels.push(Channel::new("extrapolating", flags.collect()));
    let hash = |path: &Path| -> anyhow::Result<String> { Ok(file::sha256_hex(&file::read_bytes(path)?)) };
    let meta = Metadata {
        commit: env!("HYSTERON_COMMIT").to_owned(),
        source: format!("strokes by {} for {}", arguments.checkpoint.display(), arguments.target.display()),
        command: terminal::command_line(),
        extra: BTreeMap::from([
            ("inverse_sha256".to_owned(), hash(&arguments.checkpoint)?),
            ("target_sha256".to_owned(), hash(&arguments.target)?),
            ("limited_samples".to_owned(), limited.to_string()),
        ]),
        ..Metadata::default()
    };
    Ok(Recording::new(target.time.clone(), channels, Vec::new(), meta)?)
}
