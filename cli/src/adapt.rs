//! `hysteron adapt`: a calibrated twin learns, from a little of what is measured now, how its robot has changed.

use std::path::PathBuf;

use hysteron_base::{BadInput, Scene};
use hysteron_twin::residual::{AdaptOptions, ResidualModel};
use hysteron_twin::{Motion, Plant, Twin};
use serde_json::json;

use crate::network::Network;
use crate::{inputs, interrupt, paths, terminal};

const HELP: &str = "\
Needs a checkpoint by `hysteron fit-residual` and recordings of the robot as it is now (strokes and measured tip): a tendon \
was tensioned anew, friction has grown, a tool was put on. The network stays as it is; a correction of a few parameters, \
linear in the strokes and in what hysteresis made of them, is found sample by sample, within bounds, and slowly forgets. \
A minute of motion is enough (`record --plan quick`).

Writes the checkpoint with its correction, for `simulate --residual`, `generate`, `command --scene` and `track`, and for \
`adapt` again. Prints how far the twin's tip is off along each recording, without and with what was learned from all of \
them.

Examples, from the root of the repository:
  hysteron record --rig virtual:typical --plan quick --out out/today --seed 7
  hysteron adapt out/quick/residual.safetensors --scene meshes/tpu80/scene-typical.toml out/today \\
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
    /// Time after which what was seen counts a third
    #[arg(long, value_name = "S", default_value_t = AdaptOptions::default().memory_s)]
    memory_s: f64,
}

/// Carries out the verb.
pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    paths::check_checkpoint(&arguments.out)?;
    if !(arguments.memory_s > 0.0 && arguments.memory_s.is_finite()) {
        return Err(BadInput::new("--memory-s", "a time > 0", arguments.memory_s.to_string()).into());
    }
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
    interrupt::listen()?;
    let n_samples: usize = motions.iter().map(Motion::len).sum();
    let bar = terminal::progress("samples", 2 * n_samples, 0);
    let pass = |network: &Network, options: Option<AdaptOptions>| {
        follow(&twin, network, &motions, options, &mut || {
            bar.inc(1);
            !interrupt::is_asked()
        })
    };
    let options = AdaptOptions { memory_s: arguments.memory_s, ..AdaptOptions::default() };
    let (before, mut model) = pass(&network, Some(options))?;
    model.training["adapted_to"] = inputs.iter().map(|input| json!([input.name, input.hash])).collect();
    let adapted = network.with(model);
    let (after, _) = pass(&adapted, None)?;
    bar.finish_and_clear();
    for ((input, before), after) in inputs.iter().zip(before).zip(after) {
        terminal::say(format_args!(
            "{}: tip off by {before:.3} mm (rms) before, {after:.3} mm after",
            input.name
        ));
    }
    adapted.model().write(&arguments.out)?;
    terminal::say(arguments.out.display());
    Ok(())
}

/// Rolls out all motions, from rest each; returns the root mean square distance of the tip in each [mm], and the model with
/// what was learned on the way.
fn follow(
    twin: &Twin,
    network: &Network,
    motions: &[Motion],
    options: Option<AdaptOptions>,
    go_on: &mut dyn FnMut() -> bool,
) -> anyhow::Result<(Vec<f64>, ResidualModel)> {
    let mut distances = Vec::new();
    let mut rollout = network.rollout(twin, motions[0].step)?;
    if let Some(options) = options {
        rollout.adapt(options)?;
    }
    for motion in motions {
        rollout.restart();
        let (mut square, mut count) = (0.0, 0.0);
        for i in 0..motion.len() {
            let tip = rollout.step(motion.strokes_at(i))?.tip;
            if !motion.gap[i] {
                square += (0..3).map(|c| (tip[c] - motion.tips[i][c]).powi(2)).sum::<f64>();
                count += 1.0;
                rollout.learn(motion.tips[i]);
            }
            if !go_on() {
                anyhow::bail!("interrupted; nothing is written");
            }
        }
        distances.push(1e3 * (square / f64::max(count, 1.0)).sqrt());
    }
    Ok((distances, rollout.adapted()))
}
