//! `hysteron generate`: a plan carried out by the calibrated twin, as data to learn from.

mod card;
mod shard;
mod steer;

use std::path::PathBuf;
use std::sync::Mutex;

use hysteron_base::{BadInput, Metadata, Recording, Scene, file};
use hysteron_control::Trajectory;
use hysteron_control::plan::Space;
use hysteron_twin::Error;
use hysteron_twin::Twin;
use hysteron_twin::synthetic::{Drive, Outcome, Recorded, Unphysical, synthesise};
use rayon::prelude::*;

pub use card::{Card, Row, tip_of};
use shard::Shard;
use steer::Steered;

use crate::network::{Network, plant};
use crate::outputs::Outputs;
use crate::{figures, inputs, interrupt, plan, terminal};

const HELP: &str = "\
Needs a scene and a plan: a file (docs in control/README.md) or a name, `synthetic` (the 25 trajectories of the CoReAct paper, \
387 000 samples), `roses` (eight ways of the tip in ever new directions), `paper`, `quick`. In a plan with space = \"tip\" the curves are where \
the tip shall go: the twin is steered along them, within the plan's limits, and the strokes that did it are carried out. With --residual, a checkpoint by `hysteron fit-residual`, the twin shows the robot's \
hysteresis; without one it is the bare twin.

Writes to DIR a recording for every trajectory, as a rig would (stroke_1_m, ..., tip_x_m, ...), with tensions, with what a \
small change of a stroke does to the tip (tip_x_per_stroke_1_ratio, ...), which `hysteron train` makes use of, and with \
extrapolating, 1 where the network left its training range; and report.html and metrics.json, the card of the data set. A \
trajectory that the twin cannot do (no equilibrium, a tendon at its largest tension, a tip that jumps) is left out as a \
whole, and counted.

Trajectories that are there already, from the same plan, scene and checkpoint, are kept: run the command again to go on. \
For several machines, --shard 1/3, 2/3 and 3/3 make a third of the trajectories each, the same bytes as without it; put \
their files into one folder, and run it once more for the card of all.

Examples, from the root of the repository:
  hysteron generate meshes/tpu80/scene.toml --plan quick --out out/bare
  hysteron generate meshes/tpu80/scene-typical.toml --residual out/quick/residual.safetensors \\
      --out out/synthetic --real out/quick

Exit codes: 0 done, 1 failed or interrupted (finished trajectories are kept), 2 bad input.";

/// Let the calibrated twin carry out a plan: synthetic data
#[derive(Debug, clap::Args)]
#[command(after_help = HELP)]
pub struct Arguments {
    /// Scene file of the robot (scene.toml)
    scene: PathBuf,
    /// Checkpoint by hysteron fit-residual
    #[arg(long, value_name = "CKPT")]
    residual: Option<PathBuf>,
    /// Plan file (.toml), or the name of a built-in plan
    #[arg(long, value_name = "PLAN", default_value = "synthetic")]
    plan: String,
    /// Folder to write to
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Only the I-th of N parts of the trajectories
    #[arg(long, value_name = "I/N")]
    shard: Option<Shard>,
    /// Recordings of the robot, or folders of them, to compare with on the card
    #[arg(long, value_name = "REC", num_args = 1..)]
    real: Vec<PathBuf>,
    /// Write the figure as .png too
    #[arg(long)]
    png: bool,
}

/// Copy of the plan, beside the data.
const PLAN: &str = "plan.toml";

/// A trajectory and where it goes.
struct Job<'a> {
    trajectory: &'a Trajectory,
    meta: Metadata,
    out: PathBuf,
}

/// Carries out the verb.
pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let scene = Scene::read(&arguments.scene)?;
    let twin = Twin::from_scene(&scene)?;
    let (plan, text) = plan::read(&arguments.plan)?;
    plan::check_tendons(&plan, &plan::angles_of(&scene), &format!("scene {}", scene.name))?;
    let n_trajectories = plan.trajectories().len();
    if let Some(shard) = arguments.shard.filter(|shard| shard.of() > n_trajectories) {
        let expected = format!("at most {n_trajectories} parts, the trajectories of plan {}", plan.name);
        return Err(BadInput::new("--shard", expected, shard.of().to_string()).into());
    }
    let network = arguments.residual.as_deref().map(|path| Network::read(path, &scene, &twin)).transpose()?;
    let real = if arguments.real.is_empty() { Vec::new() } else { inputs::read(&arguments.real)? };
    let jobs = plan.trajectories().iter().enumerate();
    let jobs = jobs.filter(|(k, _)| arguments.shard.is_none_or(|shard| shard.has(*k)));
    let jobs = jobs.map(|(_, one)| job(arguments, &scene, network.as_ref(), one));
    let (mut rows, mut missing) = (Vec::new(), Vec::new());
    for job in jobs.collect::<anyhow::Result<Vec<_>>>()? {
        match there(&job) {
            Some(recording) => rows.push(made(&job, recording)?),
            None => missing.push(job),
        }
    }
    let _claim = outputs(arguments, &scene, &text, &real, &missing)?.check()?;
    let n_jobs = rows.len() + missing.len();
    let n_samples = missing.iter().map(|job| job.trajectory.n_samples()).sum::<usize>();
    tracing::info!(
        "{}, plan {}: {n_jobs} trajectories, {n_samples} samples to do; {} are there already",
        scene.name,
        plan.name,
        rows.len(),
    );
    interrupt::listen()?;
    let bar = terminal::progress("samples", n_samples, 0);
    let found = Mutex::new(Vec::new());
    missing.par_iter().try_for_each(|job| -> anyhow::Result<()> {
        let rate = job.trajectory.rate_hz;
        let mut go_on = || {
            bar.inc(1);
            !interrupt::is_asked()
        };
        let mut plant = plant(network.as_ref(), &twin, rate.recip())?;
        let mut carry_out =
            |drive: &mut dyn Drive| synthesise(&twin, &mut *plant, drive, job.meta.clone(), &mut go_on);
        let coordinates =
            |point: [f64; 2], strokes: &mut [f64]| job.trajectory.tendons.strokes_into(point, strokes);
        let outcome = match job.trajectory.space {
            Space::Tendons => carry_out(&mut Recorded::new(&twin, &job.trajectory.commands()?)?)?,
            Space::Tip => match Steered::new(&twin, job.trajectory, &coordinates, plan.limits) {
                Ok(mut steered) => carry_out(&mut steered)?,
                Err(Error::NoEquilibrium { .. }) => Outcome::Dropped(0, Unphysical::NoEquilibrium),
                Err(other) => return Err(other.into()),
            },
        };
        let row = match outcome {
            Outcome::Ended => return Ok(()),
            Outcome::Made(recording) => {
                recording.write(&job.out)?;
                made(job, recording)?
            }
            Outcome::Dropped(sample, why) => {
                let why = format!("{why} at {:.2} s", sample as f64 / rate);
                tracing::warn!("{}: left out: {why}", job.trajectory.name);
                Row::dropped(job.trajectory, why)
            }
        };
        if let Ok(mut found) = found.lock() {
            found.push(row);
        }
        Ok(())
    })?;
    bar.finish_and_clear();
    rows.extend(found.into_inner().unwrap_or_default());
    rows.sort_by(|a, b| a.name.cmp(&b.name));
    finish(arguments, (&scene, &plan.name, &text), rows, &real, n_jobs)
}

/// What is read, and what will be written: not what is there already.
fn outputs(
    arguments: &Arguments,
    scene: &Scene,
    plan: &str,
    real: &[inputs::Input],
    missing: &[Job],
) -> anyhow::Result<Outputs> {
    let outputs = Outputs::reading(real.iter().map(|input| &input.path))
        .scene(&arguments.scene, scene)
        .and(&arguments.residual);
    let outputs = missing.iter().fold(outputs, |outputs, job| outputs.file("--out", &job.out));
    // The copy of the plan does not say where it is from; its report does.
    let copy = arguments.out.join(PLAN);
    let is_new = !copy.exists() || file::read_text(&copy)? == plan;
    let has_report = arguments.out.join("metrics.json").exists();
    let outputs = if is_new || has_report { outputs } else { outputs.file("--out", copy) };
    Ok(outputs.report("--out", Some(&arguments.out)))
}

/// The card and what is said.
fn finish(
    arguments: &Arguments,
    (scene, plan, text): (&Scene, &str, &str),
    rows: Vec<Row>,
    real: &[inputs::Input],
    n_jobs: usize,
) -> anyhow::Result<()> {
    if interrupt::is_asked() {
        anyhow::bail!("interrupted; {} of {n_jobs} trajectories are done; run it again to go on", rows.len());
    }
    let card = Card::new(scene, plan, rows, real);
    let copy = arguments.out.join(PLAN);
    if !copy.exists() || file::read_text(&copy)? != text {
        file::write_bytes(&copy, text)?;
    }
    figures::coverage::write(&arguments.out, &card, real, arguments.png)?;
    card.print();
    if let Some(why) = card.why_empty() {
        anyhow::bail!("{why}");
    }
    terminal::say(format_args!("report: {}", arguments.out.join("report.html").display()));
    Ok(())
}

fn job<'a>(
    arguments: &Arguments,
    scene: &Scene,
    network: Option<&Network>,
    trajectory: &'a Trajectory,
) -> anyhow::Result<Job<'a>> {
    let mut meta = trajectory.metadata();
    meta.source = format!("twin {}, {}", scene.name, meta.source);
    meta.scene_hash.clone_from(&scene.hash);
    meta.commit = env!("HYSTERON_COMMIT").to_owned();
    meta.command = terminal::command_line();
    if let Some(network) = network {
        meta.extra.insert(NETWORK.to_owned(), network.hash.clone());
    }
    Ok(Job { trajectory, meta, out: arguments.out.join(format!("{}.parquet", trajectory.name)) })
}

/// Metadata key: hash of the residual network's checkpoint.
const NETWORK: &str = "residual.sha256";

/// The recording of a trajectory, where it is there from the same plan, scene and network.
fn there(job: &Job) -> Option<Recording> {
    let is_same = |found: &Recording| {
        let keys = ["plan.sha256", NETWORK];
        found.meta().scene_hash == job.meta.scene_hash
            && keys.iter().all(|key| found.meta().extra.get(*key) == job.meta.extra.get(*key))
    };
    Recording::read(&job.out).ok().filter(is_same)
}

fn made(job: &Job, recording: Recording) -> anyhow::Result<Row> {
    Row::made(job.trajectory, recording).map_err(|bad: BadInput| bad.within(job.out.display()).into())
}
