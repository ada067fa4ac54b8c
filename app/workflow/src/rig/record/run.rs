//! The session: rig and plan, trajectories that are missing, recordings, page.

use std::path::Path;

use hysteron_actuator::health::{Baseline, Health};
use hysteron_base::{BadInput, Lock, Metadata, Recording};
use hysteron_report::folder::ReportFolder;
use hysteron_rig::calibration::RigCalibration;

use super::jobs::{self, Job, RecordWork, is_folder, split_done};
use super::options::Options;
use super::outcome::Outcome;
use super::page::{self, DataSet};
use super::simulated::Simulation;
use super::source::{self, Source};
use super::summary::Summary;
use super::tip_force::{self, TipForce};
use super::{live, partial_files};
use crate::shared::health;
use crate::shared::outputs::check_report;
use crate::tendon::sense::live::LiveSensing;
use crate::{COMMIT, Context, WorkflowError};

/// Runs the verb.
///
/// # Errors
/// Bad input; a rig that does not follow its commands; a limit that is passed; an interruption. What was measured is in files.
pub fn run(options: &Options, context: &Context) -> Result<Outcome, WorkflowError> {
    Ok(record(options, context)?)
}

fn record(options: &Options, context: &Context) -> anyhow::Result<Outcome> {
    let (session, work) = RecordingPlan::read(options)?;
    let figures = session.figures()?;
    let calibration = session.source.calibration(options.calibration.as_ref())?;
    // Until all is done: the folder, and each file for those who name it alone.
    let _folder = session.folder.map(Lock::folder).transpose()?;
    let _files = work.jobs.iter().map(|job| Lock::file(&job.out)).collect::<Result<Vec<_>, _>>()?;
    let mut description = session.source.description_files();
    description.extend(work.plan_text.map(|text| ("plan.toml", text)));
    let (there, missing) = split_done(work.jobs, &session.identity(calibration.as_ref()))?;
    if let Some(folder) = session.folder {
        source::check_description(folder, &description)?;
    }
    for (job, recording) in &there {
        partial_files::clear_journal(&job.out, recording)?;
    }
    log_begin(&work.name, &missing, there.len());
    match session.source {
        Source::Live { .. } => context.listen_on_rig(),
        Source::Virtual { .. } => context.listen(),
    }
    let mut summary = Summary::default();
    for (job, recording) in &there {
        summary.add_there(job, recording);
    }
    let ended = match &missing[..] {
        [] => Ok(()),
        missing => session.record(missing, calibration, &mut summary, context),
    };
    context.listen();
    if let Some(folder) = session.folder.filter(|_| summary.n_rows() > 0) {
        source::write_description(folder, &description)?;
    }
    summary.sort();
    summary.print(context);
    let outcome = match figures {
        // A session that ended before its first sample has nothing to report.
        _ if summary.n_rows() == 0 => Outcome::new(summary.rows(), &Metadata::default()),
        Some(figures) => session.report(figures, &work.name, &summary, context)?,
        None => Outcome::new(summary.rows(), &summary.first_meta()?),
    };
    ended.map(|()| outcome)
}

/// Logs what is to be recorded.
fn log_begin(name: &str, missing: &[Job], n_there: usize) {
    tracing::info!(
        "{name}: {} trajectories, {} samples, {:.0} s; {n_there} are there already",
        n_there + missing.len(),
        missing.iter().map(|job| job.commands.n_samples()).sum::<usize>(),
        missing.iter().map(|job| job.commands.n_samples() as f64 / job.rate_hz).sum::<f64>(),
    );
}

/// A session before anything moves: all that is read, but for its trajectories.
struct RecordingPlan<'a> {
    options: &'a Options,
    source: Source,
    tip_force: Option<TipForce>,
    baseline: Option<Baseline>,
    sensing: Option<LiveSensing>,
    /// Folder of the recordings; none for a single file.
    folder: Option<&'a Path>,
}

impl<'a> RecordingPlan<'a> {
    /// Reads what the options name, and the trajectories.
    fn read(options: &'a Options) -> anyhow::Result<(Self, RecordWork)> {
        let source = Source::read(&options.rig)?;
        let tip_force = tip_force(options, &source)?;
        let n = source.rig().tendons.len();
        let baseline = options.baseline.as_deref().map(|path| Baseline::read(path, n)).transpose()?;
        let sensing = options.live.as_ref().map(|live| LiveSensing::read(live, n)).transpose()?;
        let work = match &options.plan {
            Some(plan) if options.feedback => {
                let hint =
                    "a plan commands strokes and has no path of the tip; use hysteron track --feedback";
                return Err(BadInput::new("--feedback", "--strokes", format!("--plan {plan}"))
                    .hint(hint)
                    .into());
            }
            Some(plan) => jobs::of_plan(plan, options, &source)?,
            None => jobs::of_strokes(options, &source)?,
        };
        if let Some(sensing) = &sensing {
            work.jobs.iter().try_for_each(|job| sensing.check_rate(&job.name, job.rate_hz))?;
        }
        let folder = is_folder(&options.out).then_some(options.out.as_path());
        Ok((Self { options, source, tip_force, baseline, sensing, folder }, work))
    }

    /// Folder of the report, if there is to be one; refused where it holds another's.
    fn figures(&self) -> anyhow::Result<Option<&'a Path>> {
        let figures = self.options.figures.as_deref().or(self.folder);
        let option = if self.options.figures.is_some() { "--figures" } else { "--out" };
        figures.map_or(Ok(()), |figures| check_report(option, figures))?;
        Ok(figures)
    }

    /// Metadata of a recording of this session.
    fn identity(&self, calibration: Option<&RigCalibration>) -> Vec<(&'static str, String)> {
        let mut identity = self.source.identity(self.options.seed, calibration);
        identity.extend(self.tip_force.iter().map(|force| (tip_force::KEY, force.hash.clone())));
        identity
    }

    /// Records trajectories on the rig or its simulation.
    fn record(
        &self,
        missing: &[Job],
        calibration: Option<RigCalibration>,
        summary: &mut Summary,
        context: &Context,
    ) -> anyhow::Result<()> {
        let meta = |job: &Job, calibration: &RigCalibration| self.metadata(job, calibration, context);
        match (&self.source, calibration) {
            (Source::Live { .. }, Some(calibration)) => {
                if let Some(folder) = self.folder {
                    source::keep_calibration(folder, &calibration)?;
                }
                let sensing = self.sensing.as_ref();
                let work = live::Work { options: self.options, jobs: missing, sensing };
                live::record(&self.source, &work, &calibration, &meta, summary, context)
            }
            (source, given) => {
                let (tip_force, sensing) = (self.tip_force.as_ref(), self.sensing.as_ref());
                let simulation = Simulation { source, seed: self.options.seed, tip_force, sensing };
                simulation.record(missing, (given, self.folder), &meta, summary, context)
            }
        }
    }

    /// Provenance of a recording.
    fn metadata(&self, job: &Job, calibration: &RigCalibration, context: &Context) -> Metadata {
        let mut meta = job.commands.meta().clone();
        meta.scene_hash = String::new();
        meta.source = format!("{}, {}", self.source.description(), job.commands.meta().source);
        meta.commit = COMMIT.to_owned();
        meta.command = context.command.clone();
        let mut note = |key: &str, value: String| meta.extra.insert(key.to_owned(), value);
        note("rig.name", self.source.rig().name.clone());
        note("calibration.date", calibration.date.clone());
        if let Source::Virtual { name, .. } = &self.source {
            note("virtual.robot", name.clone());
        }
        for (key, value) in self.identity(Some(calibration)) {
            note(key, value);
        }
        meta
    }

    /// Writes the report of a session that has recordings.
    fn report(
        &self,
        folder: &Path,
        plan: &str,
        summary: &Summary,
        context: &Context,
    ) -> anyhow::Result<Outcome> {
        let recordings = summary.recordings()?;
        let angles: Vec<f64> = self.source.rig().tendons.iter().map(|tendon| tendon.angle).collect();
        let title = format!("{}: {plan}", self.source.description());
        let all: Vec<&Recording> = recordings.iter().map(|(_, recording)| recording).collect();
        let health = Health::of(&all, self.baseline.as_ref())?;
        health.iter().for_each(|health| health::print(health, context));
        let data = DataSet {
            title: &title,
            angles: &angles,
            rows: summary.rows(),
            recordings: &recordings,
            meta: all[0].meta(),
            health: health.as_ref(),
        };
        let outcome = page::write(&ReportFolder { path: folder, png: self.options.png }, &data)?;
        context.reported(folder);
        Ok(outcome)
    }
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
