//! Recording jobs: the trajectories of a plan, or strokes from files; checked before anything moves.

use std::path::{Path, PathBuf};

use hysteron_base::{BadInput, Bounds, Channel, Recording};
use hysteron_control::{MotionPlan, StrokeLimits};
use hysteron_rig::config::RigConfig;
use hysteron_rig::session::TipFeedback;

use super::options::Options;
use super::source::Source;
use crate::{shared::inputs, shared::plan};

/// A stroke that counts as none [m].
const AT_REST: f64 = 1e-5;
/// Metadata key: hash of the file that the strokes are from.
const STROKES_KEY: &str = "strokes.sha256";
/// Key of the metadata that says that strokes were corrected by the tip.
const FEEDBACK_KEY: &str = "strokes.feedback";

/// One trajectory and where its recording goes.
pub struct Job {
    /// Place among all.
    pub order: usize,
    /// Name of the trajectory.
    pub name: String,
    /// Role of the recording; empty where it is not given.
    pub role: String,
    /// Samples per second [Hz].
    pub rate_hz: f64,
    /// Strokes, sample by sample.
    pub commands: Recording,
    /// The correction of these strokes while they are run, if they get one.
    pub feedback: Option<TipFeedback>,
    /// Where its recording goes.
    pub out: PathBuf,
}

/// Everything that is to be recorded.
pub struct RecordWork {
    /// For people.
    pub name: String,
    /// The plan, if it is one.
    pub plan_text: Option<String>,
    /// Its trajectories.
    pub jobs: Vec<Job>,
}

/// A trajectory whose recording is there.
type RecordedJob = (Job, Recording);

/// Refuses a plan that would pass a limit of the rig, before anything moves.
pub fn check_against_rig(plan: &MotionPlan, source: &Source) -> anyhow::Result<()> {
    let rig = source.rig();
    let angles: Vec<f64> = rig.tendons.iter().map(|tendon| tendon.angle).collect();
    plan::check_tendons(plan, &angles, &format!("rig \"{}\"", rig.name))?;
    plan.check(&limits_of(rig)).map_err(|error| {
        anyhow::Error::new(error.within(format!("plan {} on rig \"{}\"", plan.name, rig.name)))
    })
}

/// The trajectories of a plan that are asked for.
pub fn of_plan(named: &str, options: &Options, source: &Source) -> anyhow::Result<RecordWork> {
    let (plan, text) = plan::read(named)?;
    check_against_rig(&plan, source)?;
    let all = plan.trajectories();
    if let Some(unknown) = options.only.iter().find(|name| all.iter().all(|t| t.name != **name)) {
        let names: Vec<&str> = all.iter().map(|trajectory| trajectory.name.as_str()).collect();
        return Err(
            BadInput::new("--only", format!("of {}", names.join(", ")), format!("\"{unknown}\"")).into()
        );
    }
    let is_chosen = |name: &String| options.only.is_empty() || options.only.contains(name);
    let jobs = all.iter().enumerate().filter(|(_, trajectory)| is_chosen(&trajectory.name));
    let jobs = jobs.map(|(order, trajectory)| {
        Ok(Job {
            order,
            name: trajectory.name.clone(),
            role: trajectory.role.name().to_owned(),
            rate_hz: trajectory.rate_hz,
            commands: trajectory.commands()?,
            feedback: None,
            out: out_of(options, &trajectory.name),
        })
    });
    let jobs = jobs.collect::<anyhow::Result<Vec<_>>>()?;
    check_out(options, jobs.len(), "or choose one of them with --only")?;
    Ok(RecordWork { name: format!("plan {}", plan.name), plan_text: Some(text), jobs })
}

/// Strokes from a file.
pub fn of_strokes(options: &Options, source: &Source) -> anyhow::Result<RecordWork> {
    let (rig, mut jobs) = (source.rig(), Vec::new());
    for (order, input) in inputs::read(&options.strokes)?.into_iter().enumerate() {
        let place = input.path.display();
        let strokes = input.recording.strokes();
        if strokes.len() != rig.tendons.len() {
            let expected = format!("{}, as rig \"{}\" has tendons", rig.tendons.len(), rig.name);
            return Err(BadInput::new(
                format!("{place}: stroke columns"),
                expected,
                strokes.len().to_string(),
            )
            .into());
        }
        limits_of(rig).check_commands(&input.recording).map_err(|error| error.within(place.to_string()))?;
        let n = input.recording.n_samples();
        for (k, values) in strokes.iter().enumerate() {
            for (row, when) in [(0, "begin"), (n - 1, "end")] {
                if values[row].abs() > AT_REST {
                    let found = format!("{:.3} mm", 1e3 * values[row]);
                    let place = format!("{place}: stroke_{}_m, row {}", k + 1, row + 1);
                    return Err(BadInput::new(place, format!("0 mm: strokes {when} at rest"), found).into());
                }
            }
        }
        let channels = strokes.iter().enumerate();
        let channels =
            channels.map(|(k, values)| Channel::new(format!("stroke_{}_m", k + 1), values.to_vec()));
        let feedback = options.feedback.then(|| TipFeedback::new(&input.recording, rig)).transpose();
        let feedback = feedback.map_err(|bad| bad.within(place.to_string()))?;
        let mut meta = input.recording.meta().clone();
        meta.extra.insert(STROKES_KEY.to_owned(), input.hash.clone());
        if options.feedback {
            meta.extra.insert(FEEDBACK_KEY.to_owned(), "true".to_owned());
        }
        meta.source = format!("strokes of {}", input.name);
        let time = input.recording.time();
        let time = time.iter().map(|t| t - time[0]).collect();
        jobs.push(Job {
            order,
            role: inputs::role(&meta).to_owned(),
            rate_hz: input.recording.rate_hz().unwrap_or_default(),
            commands: Recording::new(time, channels.collect(), Vec::new(), meta)?,
            feedback,
            out: out_of(options, &input.name),
            name: input.name,
        });
    }
    check_out(options, jobs.len(), "give it one recording of strokes")?;
    Ok(RecordWork { name: "strokes".to_owned(), plan_text: None, jobs })
}

fn out_of(options: &Options, name: &str) -> PathBuf {
    if is_folder(&options.out) { options.out.join(format!("{name}.parquet")) } else { options.out.clone() }
}

/// A file takes one trajectory.
fn check_out(options: &Options, n: usize, hint: &str) -> Result<(), BadInput> {
    if is_folder(&options.out) || n == 1 {
        return Ok(());
    }
    let place = format!("--out {}", options.out.display());
    Err(BadInput::new(place, format!("a folder, for {n} trajectories"), "a file").hint(hint))
}

fn limits_of(rig: &RigConfig) -> StrokeLimits {
    StrokeLimits {
        stroke: Bounds { min: rig.limits.stroke_min, max: rig.limits.stroke_max },
        stroke_rate: rig.limits.stroke_rate_max,
    }
}

/// Whether a name is that of a folder.
pub fn is_folder(out: &Path) -> bool {
    !matches!(out.extension().and_then(|ending| ending.to_str()), Some("parquet" | "csv"))
}

/// Separates the trajectories whose recordings are there, of this rig (`identity`), from those that are missing.
pub fn split_done(
    jobs: Vec<Job>,
    identity: &[(&str, String)],
) -> anyhow::Result<(Vec<RecordedJob>, Vec<Job>)> {
    let (mut there, mut missing) = (Vec::new(), Vec::new());
    for job in jobs {
        if !job.out.exists() {
            check_log(&job.out)?;
            missing.push(job);
            continue;
        }
        let recording = Recording::read(&job.out)?;
        check_done(&job, &recording, identity)?;
        there.push((job, recording));
    }
    Ok((there, missing))
}

/// Refuses a recording that is not the one that this command would make.
fn check_done(job: &Job, recording: &Recording, identity: &[(&str, String)]) -> Result<(), BadInput> {
    let place = job.out.display().to_string();
    let hint = "a measurement is never overwritten; move it away or choose another --out";
    let key_of = |recording: &Recording| {
        ["plan.sha256", STROKES_KEY, FEEDBACK_KEY].map(|key| recording.meta().extra.get(key).cloned())
    };
    let (found, expected) = (key_of(recording), key_of(&job.commands));
    if found != expected || recording.n_samples() < job.commands.n_samples() {
        let found = if found == expected { "an incomplete one" } else { "one of other commands" };
        return Err(BadInput::new(place, "a recording of these commands", found).hint(hint));
    }
    for (key, expected) in identity {
        let found = recording.meta().extra.get(*key);
        if found != Some(expected) {
            let found = found.map_or("none", String::as_str);
            return Err(BadInput::new(format!("{place}: {key}"), expected, found).hint(hint));
        }
    }
    Ok(())
}

/// Refuses a name whose log is that of another recording: NAME.parquet and NAME.csv share one.
fn check_log(out: &Path) -> Result<(), BadInput> {
    let others = ["parquet", "csv"].map(|ending| out.with_extension(ending));
    match others.iter().find(|other| *other != out && other.exists()) {
        Some(other) => {
            let found = format!("that of {}", other.display());
            Err(BadInput::new(
                out.display().to_string(),
                "a name of its own, and of its log and journal",
                found,
            )
            .hint("choose another --out"))
        }
        None => Ok(()),
    }
}
