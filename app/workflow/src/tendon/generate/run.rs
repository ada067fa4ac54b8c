//! The recipe: a plan, the trajectories that are missing, their recordings, their card.

use std::path::{Path, PathBuf};

use hysteron_base::{BadInput, Metadata, Recording, Scene, file, parallel};
use hysteron_control::{MotionPlan, Trajectory};
use hysteron_report::folder::ReportFolder;
use hysteron_twin::Twin;
use hysteron_twin::synthetic::SyntheticOutcome;

use super::options::Options;
use super::outcome::{Outcome, Scaled, SyntheticTrajectory};
use super::page;
use super::range::CalibratedRange;
use super::rollout::{NETWORK, TrajectorySimulator, reason};
use crate::shared::error::Cancelled;
use crate::shared::network::Network;
use crate::shared::outputs::Outputs;
use crate::shared::{inputs, memory, plan};
use crate::{Context, Progress, WorkflowError};

/// Plan that is used where none is named.
const DEFAULT_PLAN: &str = "synthetic";
/// Copy of the plan, next to the data.
const PLAN: &str = "plan.toml";

/// A trajectory and where it goes.
struct Job<'a> {
    trajectory: &'a Trajectory,
    meta: Metadata,
    out: PathBuf,
}

/// Runs the verb.
///
/// # Errors
/// Bad input; an interruption; files that cannot be written.
pub fn run(options: &Options, context: &Context) -> Result<Outcome, WorkflowError> {
    Ok(generate(options, context)?)
}

/// Simulates the trajectories that are missing, and writes them with their card.
fn generate(options: &Options, context: &Context) -> anyhow::Result<Outcome> {
    let scene = options.body.scene(&options.scene)?;
    let twin = Twin::from_scene(&scene)?;
    let network = options.residual.as_deref().map(|path| Network::read(path, &scene, &twin)).transpose()?;
    let real = if options.real.is_empty() { Vec::new() } else { inputs::read(&options.real)? };
    let (plan, text, scaled) = planned(options, network.as_ref(), &real, twin.n_primary, context)?;
    plan::check_tendons(&plan, &plan::angles_of(&scene), &format!("scene {}", scene.name))?;
    let n_trajectories = plan.trajectories().len();
    if let Some(shard) = options.shard.filter(|shard| shard.of() > n_trajectories) {
        let expected = format!("at most {n_trajectories} parts, the trajectories of plan {}", plan.name);
        return Err(BadInput::new("--shard", expected, shard.of().to_string()).into());
    }
    let simulator = TrajectorySimulator {
        scene: &scene,
        twin: &twin,
        network: network.as_ref(),
        limits: plan.limits,
        command: &context.command,
    };
    let jobs = plan.trajectories().iter().enumerate();
    let jobs = jobs.filter(|(k, _)| options.shard.is_none_or(|shard| shard.has(*k)));
    let jobs = jobs.map(|(_, trajectory)| Job {
        trajectory,
        meta: simulator.metadata(trajectory),
        out: options.out.join(format!("{}.parquet", trajectory.name)),
    });
    let (mut rows, mut missing) = (Vec::new(), Vec::new());
    for job in jobs {
        match there(&job) {
            Some(recording) => rows.push(made(&job, recording)?),
            None => missing.push(job),
        }
    }
    let _lock = outputs(options, &scene, &text, &real, &missing)?.check(context)?;
    // Each thread holds one recording: time, tip and extrapolation, and of every tendon stroke, tension and what it does to the tip.
    let longest = missing.iter().map(|job| job.trajectory.n_samples()).max().unwrap_or(0);
    let n_rows = longest * missing.len().min(parallel::threads());
    memory::check_result(&options.out, n_rows, 5 + 5 * twin.n_primary)?;
    let n_jobs = rows.len() + missing.len();
    let n_samples = missing.iter().map(|job| job.trajectory.n_samples()).sum::<usize>();
    tracing::info!(
        "{}, plan {}: {n_jobs} trajectories, {n_samples} samples to do; {} are there already",
        scene.name,
        plan.name,
        rows.len(),
    );
    context.listen();
    let bar = context.progress("samples", n_samples, 0);
    let find = |job: &Job| simulate(job, &simulator, &*bar, context);
    let found = parallel::try_map(&missing, find)?;
    bar.finish();
    rows.extend(found.into_iter().flatten());
    rows.sort_by(|a, b| a.name.cmp(&b.name));
    finish(options, (&scene, &plan.name, &text, scaled), rows, &real, n_jobs, context)
}

/// Simulates a trajectory and writes its recording; `None` where it was interrupted.
fn simulate(
    job: &Job,
    simulator: &TrajectorySimulator,
    bar: &dyn Progress,
    context: &Context,
) -> anyhow::Result<Option<SyntheticTrajectory>> {
    let mut go_on = || {
        bar.inc(1);
        !context.is_cancelled()
    };
    Ok(match simulator.run(job.trajectory, &mut go_on)? {
        SyntheticOutcome::Ended => None,
        SyntheticOutcome::Made(recording) => {
            recording.write(&job.out)?;
            Some(made(job, recording)?)
        }
        SyntheticOutcome::Dropped(sample, why) => {
            let why = reason(job.trajectory, sample, &why);
            tracing::warn!("{}: skipped: {why}", job.trajectory.name);
            Some(SyntheticTrajectory::dropped(job.trajectory, why))
        }
    })
}

/// The plan, its text, and the range within which it was brought, where none is named.
fn planned(
    options: &Options,
    network: Option<&Network>,
    real: &[inputs::Input],
    n_tendons: usize,
    context: &Context,
) -> anyhow::Result<(MotionPlan, String, Option<Scaled>)> {
    if let Some(named) = &options.plan {
        let (plan, text) = plan::read(named)?;
        return Ok((plan, text, None));
    }
    default_plan(options.residual.as_deref(), network, real, n_tendons, context)
}

/// The plan that is used where none is named, within the range that the twin was calibrated on.
pub(crate) fn default_plan(
    residual: Option<&Path>,
    network: Option<&Network>,
    real: &[inputs::Input],
    n_tendons: usize,
    context: &Context,
) -> anyhow::Result<(MotionPlan, String, Option<Scaled>)> {
    let by = residual.map(|path| path.display().to_string()).unwrap_or_default();
    let range = network.and_then(|network| CalibratedRange::of_network(network, n_tendons, &by));
    let Some(range) = range.or_else(|| CalibratedRange::of_recordings(real, n_tendons)) else {
        tracing::warn!(
            "the strokes of this twin's calibration are not known: plan {DEFAULT_PLAN} is run without changes (hint: --real with \
             its recordings, or --residual)"
        );
        let (plan, text) = plan::read(DEFAULT_PLAN)?;
        return Ok((plan, text, None));
    };
    let (plan, text, scale) = plan::within(DEFAULT_PLAN, &range.limits(), &range.source)?;
    context.print(format_args!(
        "no plan is named: plan {DEFAULT_PLAN} at {:.0} % of its size, within the {} of {}",
        100.0 * scale,
        range.describe(),
        range.source
    ));
    Ok((plan, text, Some(Scaled { scale, range })))
}

/// Input files, and the output files that do not exist yet.
fn outputs(
    options: &Options,
    scene: &Scene,
    plan: &str,
    real: &[inputs::Input],
    missing: &[Job],
) -> anyhow::Result<Outputs> {
    let outputs = Outputs::reading(real.iter().map(|input| &input.path))
        .scene(&options.scene, scene)
        .and(&options.residual);
    let outputs = missing.iter().fold(outputs, |outputs, job| outputs.file("--out", &job.out));
    // The copy of the plan has no provenance; its report does.
    let copy = options.out.join(PLAN);
    let is_new = !copy.exists() || file::read_text(&copy)? == plan;
    let has_report = options.out.join("metrics.json").exists();
    let outputs = if is_new || has_report { outputs } else { outputs.file("--out", copy) };
    Ok(outputs.report("--out", Some(&options.out)))
}

/// The card and the printed summary.
fn finish(
    options: &Options,
    (scene, plan, text, scaled): (&Scene, &str, &str, Option<Scaled>),
    rows: Vec<SyntheticTrajectory>,
    real: &[inputs::Input],
    n_jobs: usize,
    context: &Context,
) -> anyhow::Result<Outcome> {
    if context.is_cancelled() {
        return Err(Cancelled::new(format!(
            "; {} of {n_jobs} trajectories are done; run it again to resume",
            rows.len()
        ))
        .into());
    }
    let outcome = Outcome::new(scene, (plan, scaled), rows, real, context);
    let copy = options.out.join(PLAN);
    if !copy.exists() || file::read_text(&copy)? != text {
        file::write_bytes(&copy, text)?;
    }
    page::write(&ReportFolder { path: &options.out, png: options.png }, &outcome, real)?;
    outcome.print(context);
    if let Some(why) = outcome.why_empty() {
        anyhow::bail!("{why}");
    }
    context.reported(&options.out);
    Ok(outcome)
}

/// The recording of a trajectory, where it is there from the same plan, scene and network.
fn there(job: &Job) -> Option<Recording> {
    let is_same = |found: &Recording| {
        let keys = ["plan.sha256", NETWORK];
        found.meta().scene_hash == job.meta.scene_hash
            && keys.iter().all(|key| found.meta().extra.get(*key) == job.meta.extra.get(*key))
    };
    Recording::read(&job.out).ok().filter(is_same)
}

fn made(job: &Job, recording: Recording) -> anyhow::Result<SyntheticTrajectory> {
    SyntheticTrajectory::made(job.trajectory, recording)
        .map_err(|bad: BadInput| bad.within(job.out.display()).into())
}
