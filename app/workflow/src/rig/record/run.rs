//! The session: rig and plan, trajectories that are missing, recordings, page.

use std::path::Path;

use hysteron_base::{BadInput, Lock, Metadata, Recording};
use hysteron_report::folder::ReportFolder;
use hysteron_rig::calibration::Calibration;

use super::jobs::{self, Job, is_folder, split_done};
use super::options::Options;
use super::outcome::Outcome;
use super::page::{self, DataSet};
use super::simulated::Simulation;
use super::source::{self, Source};
use super::summary::Summary;
use super::tip_force::{self, TipForce};
use super::{live, partial_files};
use crate::shared::health::{self, Baseline, Health};
use crate::shared::outputs::check_report;
use crate::tendon::sense::live::LiveSensing;
use crate::{COMMIT, Context, WorkflowError};

/// Carries out the verb.
///
/// # Errors
/// Bad input; a rig that does not do what it is told, or a limit that is passed; an interruption. What was measured is in files.
pub fn run(options: &Options, context: &Context) -> Result<Outcome, WorkflowError> {
    Ok(record(options, context)?)
}

fn record(options: &Options, context: &Context) -> anyhow::Result<Outcome> {
    let source = Source::read(&options.rig)?;
    let tip_force = tip_force(options, &source)?;
    let n_tendons = source.rig().tendons.len();
    let baseline = options.baseline.as_deref().map(|path| Baseline::read(path, n_tendons)).transpose()?;
    let sensing = options.live.as_ref().map(|live| LiveSensing::read(live, n_tendons)).transpose()?;
    let work = match &options.plan {
        Some(plan) => jobs::of_plan(plan, options, &source)?,
        None => jobs::of_strokes(options, &source)?,
    };
    for job in sensing.iter().flat_map(|_| &work.jobs) {
        sensing.iter().try_for_each(|sensing| sensing.check_rate(&job.name, job.rate_hz))?;
    }
    let folder = is_folder(&options.out).then_some(options.out.as_path());
    let figures = options.figures.as_deref().or(folder);
    let option = if options.figures.is_some() { "--figures" } else { "--out" };
    figures.map_or(Ok(()), |figures| check_report(option, figures))?;
    let calibration = source.calibration(options.calibration.as_ref())?;
    // Until all is done: the folder, and each file for those who name it alone.
    let _folder = folder.map(Lock::folder).transpose()?;
    let _files = work.jobs.iter().map(|job| Lock::file(&job.out)).collect::<Result<Vec<_>, _>>()?;
    let mut description = source.description_files();
    description.extend(work.plan_text.map(|text| ("plan.toml", text)));
    let mut identity = source.identity(options.seed, calibration.as_ref());
    identity.extend(tip_force.iter().map(|force| (tip_force::KEY, force.hash.clone())));
    let (there, missing) = split_done(work.jobs, &identity)?;
    if let Some(folder) = folder {
        source::check_description(folder, &description)?;
    }
    for (job, recording) in &there {
        partial_files::clear_journal(&job.out, recording)?;
    }
    tracing::info!(
        "{}: {} trajectories, {} samples, {:.0} s; {} are there already",
        work.name,
        there.len() + missing.len(),
        missing.iter().map(|job| job.commands.n_samples()).sum::<usize>(),
        missing.iter().map(|job| job.commands.n_samples() as f64 / job.rate_hz).sum::<f64>(),
        there.len(),
    );
    match source {
        Source::Live { .. } => context.listen_on_rig(),
        Source::Virtual { .. } => context.listen(),
    }
    let mut summary = Summary::default();
    for (job, recording) in &there {
        summary.add_there(job, recording);
    }
    let ended = if missing.is_empty() {
        Ok(())
    } else {
        let meta = |job: &Job, calibration: &Calibration| {
            let mut meta = metadata(&source, options, job, calibration, context);
            meta.extra.extend(tip_force.iter().map(|force| (tip_force::KEY.to_owned(), force.hash.clone())));
            meta
        };
        match (&source, calibration) {
            (Source::Live { .. }, Some(calibration)) => {
                if let Some(folder) = folder {
                    source::keep_calibration(folder, &calibration)?;
                }
                let work = live::Work { options, jobs: &missing, sensing: sensing.as_ref() };
                live::record(&source, &work, &calibration, &meta, &mut summary, context)
            }
            (_, given) => {
                let (tip_force, sensing) = (tip_force.as_ref(), sensing.as_ref());
                let simulation = Simulation { source: &source, seed: options.seed, tip_force, sensing };
                simulation.record(&missing, (given, folder), &meta, &mut summary, context)
            }
        }
    };
    context.listen();
    if let Some(folder) = folder.filter(|_| summary.n_rows() > 0) {
        source::write_description(folder, &description)?;
    }
    summary.sort();
    summary.print(context);
    // A session that ended before its first sample has nothing to report.
    if summary.n_rows() == 0 {
        return ended.map(|()| Outcome::new(summary.rows(), &Metadata::default()));
    }
    let outcome = match figures {
        Some(figures) => {
            let outcome =
                report(figures, options, &source, &work.name, &summary, baseline.as_ref(), context)?;
            context.reported(figures);
            outcome
        }
        None => Outcome::new(summary.rows(), &summary.first_meta()?),
    };
    ended.map(|()| outcome)
}

/// Writes the report of a session that has recordings.
fn report(
    folder: &Path,
    options: &Options,
    source: &Source,
    plan: &str,
    summary: &Summary,
    baseline: Option<&Baseline>,
    context: &Context,
) -> anyhow::Result<Outcome> {
    let recordings = summary.recordings()?;
    let angles: Vec<f64> = source.rig().tendons.iter().map(|tendon| tendon.angle).collect();
    let title = format!("{}: {plan}", source.description());
    let all: Vec<&Recording> = recordings.iter().map(|(_, recording)| recording).collect();
    let health = Health::of(&all, baseline)?;
    health.iter().for_each(|health| health::print(health, context));
    let data = DataSet {
        title: &title,
        angles: &angles,
        rows: summary.rows(),
        recordings: &recordings,
        meta: all[0].meta(),
        health: health.as_ref(),
    };
    page::write(&ReportFolder { path: folder, png: options.png }, &data)
}

/// The force that is asked for; only a simulated tip can be pushed.
fn tip_force(options: &Options, source: &Source) -> anyhow::Result<Option<TipForce>> {
    match (&options.tip_force, source) {
        (None, _) => Ok(None),
        (Some(path), Source::Virtual { .. }) => TipForce::read(path).map(Some),
        (Some(_), Source::Live { .. }) => {
            let found = options.rig.display().to_string();
            Err(BadInput::new("--tip-force", "a virtual rig: --rig virtual:PRESET", found)
                .hint("on a real rig, push the tip by hand or hang a weight on it")
                .into())
        }
    }
}

/// Provenance of a recording.
fn metadata(
    source: &Source,
    options: &Options,
    job: &Job,
    calibration: &Calibration,
    context: &Context,
) -> Metadata {
    let mut meta = job.commands.meta().clone();
    meta.scene_hash = String::new();
    meta.source = format!("{}, {}", source.description(), job.commands.meta().source);
    meta.commit = COMMIT.to_owned();
    meta.command = context.command.clone();
    let mut note = |key: &str, value: String| meta.extra.insert(key.to_owned(), value);
    note("rig.name", source.rig().name.clone());
    note("calibration.date", calibration.date.clone());
    if let Source::Virtual { name, .. } = source {
        note("virtual.robot", name.clone());
    }
    for (key, value) in source.identity(options.seed, Some(calibration)) {
        note(key, value);
    }
    meta
}
