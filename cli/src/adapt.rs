//! `hysteron adapt`: a calibrated twin learns, from a little of what is measured now, how its robot has changed.

use std::path::PathBuf;

use hysteron_base::Scene;
use hysteron_twin::residual::{AdaptOptions, Adapted, Kept, adapt, n_samples};
use hysteron_twin::{Motion, Twin};
use serde::Serialize;
use serde_json::json;

use crate::figures::report::write_metrics;
use crate::network::Network;
use crate::outputs::Outputs;
use crate::{inputs, interrupt, number, paths, terminal};

const HELP: &str = "\
Needs a checkpoint by `hysteron fit-residual` and recordings of the robot as it is now (strokes and measured tip): a tendon \
was tensioned anew, friction or play has grown, a tool was put on. The network stays as it is. Two kinds of change are \
sought: a few physical numbers (how far each tendon is pulled at stroke zero, play of the servos, friction), and on top of \
them a correction that is linear in the strokes and in what hysteresis made of them. A minute of motion is enough \
(`record --plan quick`); motion like that of the training is best, for where the network leaves its training nothing is \
learned.

The recordings take turns: a change is fitted to the others and judged on the one held out (a single recording, or two, \
are cut into pieces). Only what does better there by a tenth is kept, where a mean of up to 0.2 mm along an axis counts as the \
tracker's drift and not as an error; a robot that has not changed keeps its checkpoint.

Writes the checkpoint with what was kept, for `simulate --residual`, `generate`, `command --scene` and `track`, and for \
`adapt` again; and metrics.json. Prints how far the twin's tip is off on what was held out, by what would be kept, the \
decision, what was found, and how far the tip is off along each recording without and with what was learned from all of \
them.

Examples, from the root of the repository:
  hysteron record --rig virtual:typical --plan quick --out out/today --seed 7
  hysteron adapt out/quick/residual.safetensors \\
      --scene meshes/tpu80/scene-typical.toml out/today \\
      --out out/today/residual.safetensors

Exit codes: 0 done, 1 failed or interrupted (nothing is written), 2 bad input.";

/// Adapt a calibrated twin to what is measured now
#[derive(Debug, clap::Args)]
#[command(after_help = HELP)]
pub struct Arguments {
    /// Checkpoint by hysteron fit-residual, or by this verb
    #[arg(value_name = "CKPT")]
    checkpoint: PathBuf,
    /// Recordings of the robot, .parquet or .csv, or folders of them; in the order of their names
    #[arg(required = true, value_name = "REC")]
    recordings: Vec<PathBuf>,
    /// Scene file of the robot (scene.toml)
    #[arg(long, value_name = "SCENE")]
    scene: PathBuf,
    /// Checkpoint to write, .safetensors
    #[arg(long, value_name = "CKPT")]
    out: PathBuf,
    /// Folder for metrics.json [default: OUT without its ending]
    #[arg(long, value_name = "DIR")]
    figures: Option<PathBuf>,
    /// Time after which what was seen counts a third
    #[arg(long, value_name = "S", default_value_t = AdaptOptions::default().memory_s, value_parser = number::time_s)]
    memory_s: f64,
}

/// Carries out the verb.
pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    paths::check_checkpoint(&arguments.out)?;
    let scene = Scene::read(&arguments.scene)?;
    let twin = Twin::from_scene(&scene)?;
    let network = Network::read(&arguments.checkpoint, &scene, &twin)?;
    let inputs = inputs::read(&arguments.recordings)?;
    let motions = inputs
        .iter()
        .map(|input| Motion::for_identification(&twin, &input.recording, &input.path.display().to_string()))
        .collect::<Result<Vec<_>, _>>()?;
    for motion in &motions {
        network.rollout(&twin, motion.step).map_err(|bad| bad.within(&motion.name))?;
    }
    let outputs = Outputs::reading(inputs.iter().map(|input| &input.path)).and([&arguments.checkpoint]);
    let _claim = outputs.scene(&arguments.scene, &scene).file("--out", &arguments.out).check()?;
    interrupt::listen()?;
    let bar = terminal::progress("samples", n_samples(&twin, &motions), 0);
    let on_sample = || {
        bar.inc(1);
        !interrupt::is_asked()
    };
    let options = AdaptOptions { memory_s: arguments.memory_s, ..AdaptOptions::default() };
    let adapted = adapt(&twin, network.auxiliary(), network.model(), &motions, &options, &on_sample)?;
    bar.finish_and_clear();
    let Some(mut adapted) = adapted else { anyhow::bail!("interrupted; nothing is written") };
    let hashes = inputs.iter().map(|input| json!([input.name, input.hash])).collect();
    adapted.model.training["adapted_to"] = hashes;
    adapted.model.training["adapted_kept"] = json!(adapted.kept);
    adapted.model.training["command"] = json!(terminal::command_line());
    adapted.model.training["commit"] = json!(env!("HYSTERON_COMMIT"));
    adapted.model.training["version"] = json!(env!("CARGO_PKG_VERSION"));
    adapted.model.write(&arguments.out)?;
    let folder = paths::beside(&arguments.out, arguments.figures.as_deref());
    write_metrics(&folder, &Metrics::new(&adapted, &options))?;
    print(&adapted);
    terminal::say(arguments.out.display());
    Ok(())
}

#[derive(Serialize)]
struct Metrics<'a> {
    format: &'static str,
    version: u32,
    kept: Kept,
    /// By what would be kept: the root mean square distance of the tip on all blocks while each was held out.
    held_out: Vec<HeldOut>,
    blocks: Vec<Block<'a>>,
    /// Beyond what the checkpoint had; in the checkpoint only where `kept` says so.
    found: Found<'a>,
    recordings: &'a [hysteron_twin::residual::MotionErrors],
    options: &'a AdaptOptions,
    command: String,
    commit: &'static str,
}

#[derive(Serialize)]
struct HeldOut {
    kept: Kept,
    rms_m: f64,
}

#[derive(Serialize)]
struct Block<'a> {
    recording: &'a str,
    time_s: [f64; 2],
}

#[derive(Serialize)]
struct Found<'a> {
    zeros_m: &'a [f64],
    play_m: f64,
    friction_ratio: f64,
    prior_weight: f64,
}

impl<'a> Metrics<'a> {
    fn new(adapted: &'a Adapted, options: &'a AdaptOptions) -> Self {
        let held_out = adapted.held_out_m.iter().map(|&(kept, rms_m)| HeldOut { kept, rms_m });
        let blocks = adapted.blocks.iter().map(|(name, time)| Block { recording: name, time_s: *time });
        Self {
            format: "hysteron-metrics",
            version: 1,
            kept: adapted.kept,
            held_out: held_out.collect(),
            blocks: blocks.collect(),
            found: Found {
                zeros_m: &adapted.found.zeros_m,
                play_m: adapted.found.play_m,
                friction_ratio: adapted.found.friction_ratio,
                prior_weight: adapted.prior_weight,
            },
            recordings: &adapted.motions,
            options,
            command: terminal::command_line(),
            commit: env!("HYSTERON_COMMIT"),
        }
    }
}

/// What would be kept, in words.
fn words(kept: Kept) -> &'static str {
    match kept {
        Kept::Nothing => "nothing new",
        Kept::Change => "zeros, play and friction",
        Kept::Correction => "a linear correction",
        Kept::Both => "zeros, play, friction and a linear correction",
    }
}

/// Prints errors held out, the decision, what was found and errors along the recordings.
fn print(adapted: &Adapted) {
    for (kept, rms) in &adapted.held_out_m {
        terminal::say(format_args!("held out, with {}: tip {:.3} mm off (rms)", words(*kept), 1e3 * rms));
    }
    terminal::say(format_args!("kept: {}", words(adapted.kept)));
    let zeros: Vec<String> = adapted.found.zeros_m.iter().map(|zero| format!("{:.2}", 1e3 * zero)).collect();
    terminal::say(format_args!(
        "found: zeros {} mm, play {:.2} mm more, friction times {:.2}",
        zeros.join(", "),
        1e3 * adapted.found.play_m,
        adapted.found.friction_ratio
    ));
    for motion in &adapted.motions {
        let outside = match motion.extrapolating {
            0.0 => String::new(),
            part => format!("; {:.0} % of it outside the network's training, not learned from", 100.0 * part),
        };
        terminal::say(format_args!(
            "{}: tip off by {:.3} mm (rms) before, {:.3} mm after{outside}",
            motion.name,
            1e3 * motion.before_m,
            1e3 * motion.after_m
        ));
    }
}
