//! Records the trajectories that are not there yet, and writes the card of all.

use std::path::{Path, PathBuf};

use hysteron_base::{Metadata, Recording, file, parallel};
use hysteron_report::folder::ReportFolder;
use hysteron_virtual_rig::virtual_arm::{Planned, VirtualArm};

use super::outcome::ArmTrajectory;
use super::selection::selected;
use super::{Options, Outcome, page};
use crate::arm::{self, virtual_arm::read_arm};
use crate::shared::error::Cancelled;
use crate::shared::outputs::Outputs;
use crate::{Context, WorkflowError};

/// Metadata key and version of the simulation model: recordings of another version differ in their physics.
const MODEL: (&str, &str) = ("virtual_arm_model", "2");
/// Copy of the arm's file, next to the data.
const ARM: &str = "arm.toml";
/// A trajectory and where it goes.
struct Job {
    planned: Planned,
    meta: Metadata,
    out: PathBuf,
}

/// Runs the verb.
///
/// # Errors
/// Bad input; files that cannot be written; an interruption.
pub fn run(options: &Options, context: &Context) -> Result<Outcome, WorkflowError> {
    Ok(generate(options, context)?)
}

fn generate(options: &Options, context: &Context) -> anyhow::Result<Outcome> {
    let (general, text) = read_arm(&options.arm)?;
    let arm = general.individual(options.seed);
    let planned = selected(options)?;
    let jobs: Vec<Job> = planned.into_iter().map(|one| job(options, &arm, one, context)).collect();
    let n_jobs = jobs.len();
    let (mut rows, mut missing) = (Vec::new(), Vec::new());
    for job in jobs {
        match there(&job) {
            Some(recording) => rows.push(ArmTrajectory::new(&job.planned, &recording)),
            None => missing.push(job),
        }
    }
    let outputs = Outputs::reading(Some(&options.arm).filter(|arm| Path::new(arm).exists()));
    let outputs = missing.iter().fold(outputs, |outputs, job| outputs.file("--out", &job.out));
    let copy = options.out.join(ARM);
    // The copy does not name the command that made it; the report next to it does.
    let is_new = !copy.exists() || file::read_text(&copy)? == text;
    let has_report = options.out.join("metrics.json").exists();
    let outputs = if is_new || has_report { outputs } else { outputs.file("--out", &copy) };
    let _lock = outputs.report("--out", Some(&options.out)).check(context)?;
    tracing::info!("{n_jobs} trajectories, {} of them are there already", rows.len());
    context.listen();
    let bar = context.progress("trajectories", n_jobs, rows.len());
    let found = parallel::try_map(&missing, |job| -> anyhow::Result<Option<ArmTrajectory>> {
        if context.is_cancelled() {
            return Ok(None);
        }
        let name = job.planned.name();
        let recording = arm.record(&job.planned.trial, options.seed, &name, job.meta.clone())?;
        recording.write(&job.out)?;
        bar.inc(1);
        Ok(Some(ArmTrajectory::new(&job.planned, &recording)))
    })?;
    bar.finish();
    rows.extend(found.into_iter().flatten());
    if context.is_cancelled() {
        return Err(Cancelled::new(format!(
            "; {} of {n_jobs} trajectories are done: the same command resumes",
            rows.len()
        ))
        .into());
    }
    rows.sort_by(|a, b| a.name.cmp(&b.name));
    if !copy.exists() || file::read_text(&copy)? != text {
        file::write_bytes(&copy, &text)?;
    }
    let outcome = Outcome::new(&arm, options.seed, rows, context);
    page::write(&ReportFolder { path: &options.out, png: false }, &outcome)?;
    context.print(format_args!(
        "{} trajectories, {} samples (virtual arm in place of NAD)",
        outcome.trajectories, outcome.samples
    ));
    context.reported(&options.out);
    Ok(outcome)
}

fn job(options: &Options, arm: &VirtualArm, planned: Planned, context: &Context) -> Job {
    let mut meta = arm::meta(context, "");
    meta.scene_hash.clone_from(&arm.hash);
    meta.seed = Some(options.seed);
    meta.extra.insert(MODEL.0.to_owned(), MODEL.1.to_owned());
    let out = options.out.join(format!("{}.parquet", planned.name()));
    Job { planned, meta, out }
}

/// The recording of a trajectory, where it is there from the same arm, seed and physics.
fn there(job: &Job) -> Option<Recording> {
    let recording = Recording::read(&job.out).ok()?;
    let (found, wanted) = (recording.meta(), &job.meta);
    let is_same = found.scene_hash == wanted.scene_hash
        && found.seed == wanted.seed
        && found.extra.get(MODEL.0) == wanted.extra.get(MODEL.0)
        && found.extra.get("trajectory") == Some(&job.planned.name());
    is_same.then_some(recording)
}
