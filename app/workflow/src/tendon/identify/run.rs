//! The identification: recordings, the auxiliary strokes of each, files, page.

use std::path::{Path, PathBuf};

use hysteron_base::checks::Purpose;
use hysteron_base::{BadInput, Metadata, Recording, Scene, json, parallel};
use hysteron_report::folder::ReportFolder;
use hysteron_twin::coreact::{AuxiliaryLimits, AuxiliaryPolicy, Identifier, IdentifyOptions, identify};
use hysteron_twin::residual::{DECODER, ResidualDesign};
use hysteron_twin::{RobotMotion, Twin};

use super::options::Options;
use super::outcome::{IdentifiedRecording, Outcome};
use super::page::{self, StrokeChoice};
use crate::shared::error::Cancelled;
use crate::shared::inputs::{self, Input};
use crate::shared::network::Network;
use crate::shared::outputs::Outputs;
use crate::shared::{locking, recording_checks};
use crate::{COMMIT, Context, WorkflowError};

/// Folder for what a stroke does to the tip, in that of the results.
const SENSITIVITY: &str = "sensitivity";

/// A recording to identify and where its results go.
struct Job {
    input: Input,
    motion: RobotMotion,
    meta: Metadata,
    out: PathBuf,
    sensitivity: PathBuf,
}

/// Runs the verb.
///
/// # Errors
/// Bad input; a step of the twin that fails; an interruption, after the recordings that are done are written.
pub fn run(options: &Options, context: &Context) -> Result<Outcome, WorkflowError> {
    Ok(identify_recordings(options, context)?)
}

fn identify_recordings(options: &Options, context: &Context) -> anyhow::Result<Outcome> {
    let settings = settings(options);
    let scene = options.body.scene(&options.scene)?;
    let inputs = inputs::read(&options.recordings)?;
    let twin = Twin::from_scene(&scene)?;
    let findings = recording_checks::of_inputs(&inputs, &recording_checks::context_of(&twin, Purpose::Fit))?;
    let mut excluded = Vec::new();
    let recorded = motions(options, &twin, inputs, &mut excluded)?;
    // From here on the stiffness is factorised.
    let auxiliary = AuxiliaryLimits::new(&twin)?;
    let network = options.residual.as_ref().map(|path| Network::read(path, &scene, &twin)).transpose()?;
    locking::warn_before_fit(&scene)?;
    let recorded = registered(options, &twin, recorded, &mut excluded)?;
    let jobs = recorded
        .into_iter()
        .map(|(input, motion)| job(options, &scene, network.as_ref(), input, motion, context))
        .collect::<anyhow::Result<Vec<_>>>()?;
    let (there, missing): (Vec<Job>, Vec<Job>) = jobs.into_iter().partition(is_done);
    let _lock = outputs(options, &scene, [&there, &missing]).check(context)?;
    let n_jobs = there.len() + missing.len();
    tracing::info!(
        "{}: {n_jobs} recordings, {} samples, {} auxiliary tendons; {} recordings are there already",
        scene.name,
        n_samples(&there) + n_samples(&missing),
        auxiliary.len(),
        there.len(),
    );
    context.listen();
    let policy = |motion: &RobotMotion| -> anyhow::Result<Box<dyn AuxiliaryPolicy + '_>> {
        Ok(match &network {
            Some(network) => Box::new(network.rollout(&twin, motion.step)?),
            None => Box::new(Identifier::new(&twin, &auxiliary, settings)),
        })
    };
    let mut rows =
        there.iter().map(|job| IdentifiedRecording::read(&job.out)).collect::<anyhow::Result<Vec<_>>>()?;
    rows.extend(identify_all(&missing, &twin, &policy, context)?);
    rows.sort_by(|a, b| a.name.cmp(&b.name));
    let n_done = rows.len();
    let outcome = Outcome::new(rows, excluded, &findings, (&scene.hash, context));
    print(&outcome.recordings, context);
    let title = format!("Auxiliary strokes of {}", scene.name);
    let policy = if network.is_some() { StrokeChoice::ByNetwork } else { StrokeChoice::ByQps };
    page::write(&ReportFolder { path: &options.out, png: false }, &title, policy, &outcome)?;
    context.reported(&options.out);
    if context.is_cancelled() {
        return Err(Cancelled::new(format!(
            "; {n_done} of {n_jobs} recordings are done; run it again to resume"
        ))
        .into());
    }
    Ok(outcome)
}

/// Input files, and the output files that do not exist yet.
fn outputs(options: &Options, scene: &Scene, [there, missing]: [&[Job]; 2]) -> Outputs {
    let outputs = Outputs::reading(there.iter().chain(missing).map(|job| &job.input.path))
        .scene(&options.scene, scene)
        .and(&options.residual)
        .folder("--out", options.out.join(SENSITIVITY));
    let results = missing.iter().flat_map(|job| [&job.out, &job.sensitivity]);
    let outputs = results.fold(outputs, |outputs, path| outputs.file("--out", path));
    outputs.report_of_results("--out", &options.out)
}

fn n_samples(jobs: &[Job]) -> usize {
    jobs.iter().map(|job| job.motion.len()).sum()
}

/// Identifies recordings in parallel; gives those that were brought to their end.
fn identify_all<'a>(
    jobs: &[Job],
    twin: &Twin,
    policy: &(dyn Fn(&RobotMotion) -> anyhow::Result<Box<dyn AuxiliaryPolicy + 'a>> + Sync),
    context: &Context,
) -> anyhow::Result<Vec<IdentifiedRecording>> {
    let bar = context.progress("samples", n_samples(jobs), 0);
    let rows = parallel::try_map(jobs, |job| -> anyhow::Result<Option<IdentifiedRecording>> {
        let mut go_on = || {
            bar.inc(1);
            !context.is_cancelled()
        };
        let start = std::time::Instant::now();
        let result = identify(twin, &mut *policy(&job.motion)?, &job.motion, job.meta.clone(), &mut go_on);
        let done = result
            .map_err(|error| anyhow::Error::new(error).context(job.input.path.display().to_string()))?;
        let Some(done) = done else { return Ok(None) };
        tracing::debug!(
            "{}: {:.0} steps/s",
            job.input.name,
            job.motion.len() as f64 / start.elapsed().as_secs_f64()
        );
        done.sensitivities.write(&job.sensitivity)?;
        done.recording.write(&job.out)?;
        Ok(Some(IdentifiedRecording { name: job.input.name.clone(), summary: done.summary }))
    })?;
    bar.finish();
    Ok(rows.into_iter().flatten().collect())
}

/// Recordings that can be identified, by all that is known without a step of the twin.
fn motions(
    options: &Options,
    twin: &Twin,
    inputs: Vec<Input>,
    excluded: &mut Vec<String>,
) -> anyhow::Result<Vec<(Input, RobotMotion)>> {
    let mut recorded = Vec::new();
    for input in inputs {
        let motion = RobotMotion::identifiable(twin, &input.recording, &input.path.display().to_string());
        if let Some(motion) = usable(options, motion, excluded)? {
            recorded.push((input, motion));
        }
    }
    refuse_none(&recorded)?;
    Ok(recorded)
}

/// Those of them whose tip rests where the twin's does.
fn registered(
    options: &Options,
    twin: &Twin,
    recorded: Vec<(Input, RobotMotion)>,
    excluded: &mut Vec<String>,
) -> anyhow::Result<Vec<(Input, RobotMotion)>> {
    let mut registered = Vec::new();
    for (input, motion) in recorded {
        if usable(options, motion.check_registration(twin), excluded)?.is_some() {
            registered.push((input, motion));
        }
    }
    refuse_none(&registered)?;
    Ok(registered)
}

/// A value; `None` for a recording that is skipped, whose reason joins `excluded`.
fn usable<T>(
    options: &Options,
    value: hysteron_twin::Result<T>,
    excluded: &mut Vec<String>,
) -> anyhow::Result<Option<T>> {
    match value {
        Ok(value) => Ok(Some(value)),
        Err(bad) if options.skip_bad => {
            tracing::warn!("skipped: {bad}");
            excluded.push(bad.to_string());
            Ok(None)
        }
        Err(bad) => Err(bad.into()),
    }
}

fn refuse_none(recorded: &[(Input, RobotMotion)]) -> Result<(), BadInput> {
    match recorded {
        [] => Err(BadInput::new("recordings", "at least one that can be used", "none")),
        _ => Ok(()),
    }
}

fn settings(options: &Options) -> IdentifyOptions {
    IdentifyOptions {
        regularisation: options.regularisation,
        orientation: options.orientation_mm.map(|mm| 1e-3 * mm),
        rounds: options.rounds,
        ..IdentifyOptions::default()
    }
}

fn job(
    options: &Options,
    scene: &Scene,
    network: Option<&Network>,
    input: Input,
    motion: RobotMotion,
    context: &Context,
) -> anyhow::Result<Job> {
    let mut meta = input.recording.meta().clone();
    meta.source = format!("virtual strokes of {} for {}", scene.name, meta.source);
    meta.scene_hash = scene.hash.clone();
    meta.commit = COMMIT.to_owned();
    meta.command = context.command.clone();
    meta.extra.insert("identify.input_sha256".to_owned(), input.hash.clone());
    let numbers = (options.regularisation, options.orientation_mm, options.rounds);
    let numbers =
        network.map_or_else(|| format!("{numbers:?}"), |network| format!("residual {}", network.hash));
    meta.extra.insert("identify.options".to_owned(), numbers);
    if let Some(ResidualDesign::Recurrent { decoder, .. }) = network.map(|network| &network.model().design) {
        meta.extra.insert(DECODER.to_owned(), json::to_line(decoder)?);
    }
    let file = format!("{}.parquet", input.name);
    let (out, sensitivity) = (options.out.join(&file), options.out.join(SENSITIVITY).join(&file));
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

/// Prints one line per recording.
fn print(rows: &[IdentifiedRecording], context: &Context) {
    for IdentifiedRecording { name, summary } in rows {
        let mm = |metres: f64| 1e3 * metres;
        context.print(format_args!(
            "{name}: tip off by {:.3} mm in the median without, {:.3} mm with (99 %: {:.3} mm)",
            mm(summary.before.median_m),
            mm(summary.after.median_m),
            mm(summary.after.p99_m),
        ));
    }
}
