//! `hysteron identify`: recordings become strokes of virtual tendons.

pub mod summary;

use std::path::{Path, PathBuf};
use std::sync::Mutex;

use hysteron_base::{BadInput, Metadata, Recording, Scene};
use hysteron_twin::coreact::{Auxiliary, Chooser, Identifier, IdentifyOptions, identify};
use hysteron_twin::residual::{DECODER, Design};
use hysteron_twin::{Motion, Twin};
use rayon::prelude::*;

use crate::figures::identification::Chosen;
use crate::inputs::{self, Input};
use crate::network::Network;
use crate::outputs::Outputs;
use crate::{figures, interrupt, number, terminal};

const HELP: &str = "\
Needs a scene with virtual tendons ([auxiliary]) and recordings of the robot at a fixed rate: time_s, stroke_1_mm, ... \
and the measured tip, tip_x_mm, tip_y_mm, tip_z_mm, in the frame of the scene. A folder stands for all recordings in \
it. Fit the scene to the robot first (hysteron fit-material): what physics can explain, no virtual tendon need.

For every sample one QP finds the strokes of the virtual tendons that bring the twin's tip to the measured one, within \
the scene's bounds on stroke, rate and tension (compensatory residual actuation). A virtual tendon's stroke is the one \
that its tension would make on the straight body; zero does nothing. With --residual a network chooses the strokes instead, \
in closed loop: what hysteron fit-residual takes for a second, better network.

Writes to DIR, for every recording, one with strokes, measured tip, virtual strokes aux_01_m, ..., the twin's tip with \
them (twin_x_m, ...) and without (bare_x_m, ...); in DIR/sensitivity what a stroke does to the tip; and report.html and \
metrics.json. Recordings that are there already, made from the same file with the same options, are kept: run the \
command again to go on.

Examples, from the root of the repository:
  hysteron record --rig virtual:typical --plan quick --out out/quick
  hysteron identify meshes/tpu80/scene-typical.toml out/quick --out out/quick/identified

Exit codes: 0 done, 1 failed or interrupted (finished recordings are kept), 2 bad input.";

/// More than any sample needs.
pub const MOST_ROUNDS: usize = 100;

/// Find the virtual tendons' strokes that make the twin follow measured tips (CoReAct)
#[derive(Debug, clap::Args)]
#[command(after_help = HELP)]
pub struct Arguments {
    /// Scene file of the robot (scene.toml), with virtual tendons
    scene: PathBuf,
    /// Recordings, .parquet or .csv, or folders of them
    #[arg(required = true, value_name = "REC")]
    recordings: Vec<PathBuf>,
    /// Folder to write to
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Weight of the squared strokes, over the mean squared effect of a stroke on the tip
    #[arg(long, value_name = "GAMMA", default_value_t = 1e-4, value_parser = number::weight)]
    regularisation: f64,
    /// Match the tip's orientation too, where recorded: a radian counts as much as this distance
    #[arg(long, value_name = "MM", value_parser = number::length_mm)]
    orientation_mm: Option<f64>,
    /// Rounds of QP and simulation per sample at most
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = number::count::<MOST_ROUNDS>)]
    rounds: usize,
    /// Let this network choose the strokes, instead of QPs
    #[arg(long, value_name = "CKPT", conflicts_with_all = ["regularisation", "orientation_mm", "rounds"])]
    residual: Option<PathBuf>,
    /// Leave out recordings that cannot be used, and say so, instead of stopping
    #[arg(long)]
    skip_bad: bool,
}

/// Folder for what a stroke does to the tip, in that of the results.
const SENSITIVITY: &str = "sensitivity";

/// A recording to identify and where its results go.
struct Job {
    input: Input,
    motion: Motion,
    meta: Metadata,
    out: PathBuf,
    sensitivity: PathBuf,
}

/// Carries out the verb.
pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let options = options(arguments);
    let scene = Scene::read(&arguments.scene)?;
    let twin = Twin::from_scene(&scene)?;
    let auxiliary = Auxiliary::new(&twin)?;
    let network = arguments.residual.as_ref().map(|path| Network::read(path, &scene, &twin)).transpose()?;
    let (jobs, excluded) = jobs(arguments, &scene, &twin, network.as_ref())?;
    let (there, missing): (Vec<Job>, Vec<Job>) = jobs.into_iter().partition(is_done);
    let _claim = outputs(arguments, &scene, [&there, &missing]).check()?;
    let n_jobs = there.len() + missing.len();
    tracing::info!(
        "{}: {n_jobs} recordings, {} samples, {} virtual tendons; {} recordings are there already",
        scene.name,
        n_samples(&there) + n_samples(&missing),
        auxiliary.len(),
        there.len(),
    );
    interrupt::listen()?;
    let chooser = |motion: &Motion| -> anyhow::Result<Box<dyn Chooser + '_>> {
        Ok(match &network {
            Some(network) => Box::new(network.rollout(&twin, motion.step)?),
            None => Box::new(Identifier::new(&twin, &auxiliary, options)),
        })
    };
    let mut rows =
        there.iter().map(|job| summary::Row::read(&job.out)).collect::<anyhow::Result<Vec<_>>>()?;
    rows.extend(carry_out(&missing, &twin, &chooser)?);
    rows.sort_by(|a, b| a.name.cmp(&b.name));
    summary::print(&rows);
    let title = format!("Auxiliary strokes of {}", scene.name);
    let chosen = if network.is_some() { Chosen::ByNetwork } else { Chosen::ByQps };
    figures::identification::write(&arguments.out, &title, chosen, &scene.hash, &rows, &excluded)?;
    if interrupt::is_asked() {
        let n_done = rows.len();
        anyhow::bail!("interrupted; {n_done} of {n_jobs} recordings are done; run it again to go on");
    }
    Ok(())
}

/// What is read, and what will be written: not what is there already.
fn outputs(arguments: &Arguments, scene: &Scene, [there, missing]: [&[Job]; 2]) -> Outputs {
    let outputs = Outputs::reading(there.iter().chain(missing).map(|job| &job.input.path))
        .scene(&arguments.scene, scene)
        .and(&arguments.residual)
        .folder("--out", arguments.out.join(SENSITIVITY));
    let results = missing.iter().flat_map(|job| [&job.out, &job.sensitivity]);
    let outputs = results.fold(outputs, |outputs, path| outputs.file("--out", path));
    outputs.report("--out", Some(&arguments.out))
}

fn n_samples(jobs: &[Job]) -> usize {
    jobs.iter().map(|job| job.motion.len()).sum()
}

/// Identifies recordings in parallel; gives those that were brought to their end.
fn carry_out<'a>(
    jobs: &[Job],
    twin: &Twin,
    chooser: &(dyn Fn(&Motion) -> anyhow::Result<Box<dyn Chooser + 'a>> + Sync),
) -> anyhow::Result<Vec<summary::Row>> {
    let bar = terminal::progress("samples", n_samples(jobs), 0);
    let rows = Mutex::new(Vec::new());
    jobs.par_iter().try_for_each(|job| -> anyhow::Result<()> {
        let mut go_on = || {
            bar.inc(1);
            !interrupt::is_asked()
        };
        let start = std::time::Instant::now();
        let result = identify(twin, &mut *chooser(&job.motion)?, &job.motion, job.meta.clone(), &mut go_on);
        let done = result
            .map_err(|error| anyhow::Error::new(error).context(job.input.path.display().to_string()))?;
        let Some(done) = done else { return Ok(()) };
        tracing::debug!(
            "{}: {:.0} steps/s",
            job.input.name,
            job.motion.len() as f64 / start.elapsed().as_secs_f64()
        );
        done.sensitivities.write(&job.sensitivity)?;
        done.recording.write(&job.out)?;
        if let Ok(mut rows) = rows.lock() {
            rows.push(summary::Row { name: job.input.name.clone(), summary: done.summary });
        }
        Ok(())
    })?;
    bar.finish_and_clear();
    Ok(rows.into_inner().unwrap_or_default())
}

/// What is to be done, and why other recordings are left out.
fn jobs(
    arguments: &Arguments,
    scene: &Scene,
    twin: &Twin,
    network: Option<&Network>,
) -> anyhow::Result<(Vec<Job>, Vec<String>)> {
    let mut excluded = Vec::new();
    let mut jobs = Vec::new();
    for input in inputs::read(&arguments.recordings)? {
        match Motion::for_identification(twin, &input.recording, &input.path.display().to_string()) {
            Ok(motion) => jobs.push(job(arguments, scene, network, input, motion)?),
            Err(bad) if arguments.skip_bad => {
                tracing::warn!("left out: {bad}");
                excluded.push(bad.to_string());
            }
            Err(bad) => return Err(bad.into()),
        }
    }
    if jobs.is_empty() {
        return Err(BadInput::new("recordings", "at least one that can be used", "none").into());
    }
    Ok((jobs, excluded))
}

fn options(arguments: &Arguments) -> IdentifyOptions {
    IdentifyOptions {
        regularisation: arguments.regularisation,
        orientation: arguments.orientation_mm.map(|mm| 1e-3 * mm),
        rounds: arguments.rounds,
        ..IdentifyOptions::default()
    }
}

fn job(
    arguments: &Arguments,
    scene: &Scene,
    network: Option<&Network>,
    input: Input,
    motion: Motion,
) -> anyhow::Result<Job> {
    let mut meta = input.recording.meta().clone();
    meta.source = format!("virtual strokes of {} for {}", scene.name, meta.source);
    meta.scene_hash = scene.hash.clone();
    meta.commit = env!("HYSTERON_COMMIT").to_owned();
    meta.command = terminal::command_line();
    meta.extra.insert("identify.input_sha256".to_owned(), input.hash.clone());
    let options = (arguments.regularisation, arguments.orientation_mm, arguments.rounds);
    let options =
        network.map_or_else(|| format!("{options:?}"), |network| format!("residual {}", network.hash));
    meta.extra.insert("identify.options".to_owned(), options);
    if let Some(Design::Stateful { decoder, .. }) = network.map(|network| &network.model().design) {
        meta.extra.insert(DECODER.to_owned(), serde_json::to_string(decoder)?);
    }
    let file = format!("{}.parquet", input.name);
    let (out, sensitivity) = (arguments.out.join(&file), arguments.out.join(SENSITIVITY).join(&file));
    Ok(Job { input, motion, meta, out, sensitivity })
}

/// True where both results are there, from the same recording, scene and options.
fn is_done(job: &Job) -> bool {
    let is_same = |path: &Path| {
        Recording::read(path).is_ok_and(|found| {
            let keys = ["identify.input_sha256", "identify.options"];
            found.meta().scene_hash == job.meta.scene_hash
                && keys.iter().all(|key| found.meta().extra.get(*key) == job.meta.extra.get(*key))
        })
    };
    is_same(&job.out) && is_same(&job.sensitivity)
}
