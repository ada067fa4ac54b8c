//! `hysteron arm generate`: the data set NAD as the virtual arm records it.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use hysteron_base::{BadInput, Metadata, Recording, file, parallel};
use hysteron_report::page::{Page, write_metrics, write_page};
use hysteron_rig::virtual_arm::{Planned, SPLITS, VirtualArm, data_set, fault_set};
use serde::Serialize;
use serde_json::Value;

use crate::shared::error::Cancelled;
use crate::shared::outputs::Outputs;
use crate::{COMMIT, Context};

/// Record the data set NAD with the virtual arm: a stand-in where the real one is absent
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    /// Folder to write to: SUBSET/TASK/SPLIT/NUMBER.parquet, as in NAD
    #[cfg_attr(feature = "clap", arg(long, value_name = "DIR"))]
    pub out: PathBuf,
    /// Virtual arm: a file of TOML or a built-in name
    #[cfg_attr(feature = "clap", arg(long, value_name = "ARM", default_value = "open-manipulator-x"))]
    pub arm: String,
    /// Draws the individual arm, its motions and its noise
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value_t = 0))]
    pub seed: u64,
    /// Only these subsets: `force_unlabeled`, `force_sensor`, `weight`, `motor_condition`; and `motor_faults`, which NAD does not have
    #[cfg_attr(feature = "clap", arg(long, value_name = "NAME,...", value_delimiter = ','))]
    pub subsets: Vec<String>,
    /// Only tasks whose names contain one of these, as in `sweep,pick_place`
    #[cfg_attr(feature = "clap", arg(long, value_name = "TEXT,...", value_delimiter = ','))]
    pub tasks: Vec<String>,
    /// Only these splits: train, validation, test
    #[cfg_attr(feature = "clap", arg(long, value_name = "NAME,...", value_delimiter = ','))]
    pub splits: Vec<String>,
    /// Only trajectories with these payloads, 0 for none
    #[cfg_attr(feature = "clap", arg(long, value_name = "G,...", value_delimiter = ','))]
    pub payloads_g: Vec<u32>,
    /// At most this many trajectories of a task and split
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", value_parser = crate::shared::number::count::<8>))]
    pub trajectories: Option<usize>,
}

/// Metadata key and version of the simulation model: recordings of another version differ in their physics.
const MODEL: (&str, &str) = ("virtual_arm_model", "2");
/// Copy of the arm's file, beside the data.
const ARM: &str = "arm.toml";
/// Introduction on every page of the data set.
const ABOUT: &str = "Virtual arm, stand-in for NAD: simulated with the tasks, channels, rates and quantisation of that data set, not \
                     measured on a robot. Channels truth_* are known to the simulation alone and are no inputs.";

/// A trajectory and where it goes.
struct Job {
    planned: Planned,
    meta: Metadata,
    out: PathBuf,
}

#[derive(Debug, Clone, Serialize)]
struct Row {
    name: String,
    samples: usize,
    duration_s: f64,
    /// Of the rows [-].
    labelled: f64,
    condition: String,
    payload_kg: f64,
}

#[derive(Debug, Serialize)]
struct Card<'a> {
    format: &'static str,
    version: u32,
    about: &'static str,
    arm: &'a str,
    arm_sha256: &'a str,
    seed: u64,
    trajectories: usize,
    samples: usize,
    duration_min: f64,
    rows: &'a [Row],
    command: &'a str,
    commit: &'a str,
}

/// Carries out the verb.
///
/// # Errors
/// Bad input; files that cannot be written; an interruption.
pub fn run(options: &Options, context: &Context) -> anyhow::Result<Value> {
    let (general, text) = read_arm(&options.arm)?;
    let arm = general.individual(options.seed);
    let planned = selected(options)?;
    let jobs: Vec<Job> = planned.into_iter().map(|one| job(options, &arm, one, context)).collect();
    let n_jobs = jobs.len();
    let (mut rows, mut missing) = (Vec::new(), Vec::new());
    for job in jobs {
        match there(&job) {
            Some(recording) => rows.push(row(&job, &recording)?),
            None => missing.push(job),
        }
    }
    let outputs = Outputs::reading(Some(&options.arm).filter(|arm| Path::new(arm).exists()));
    let outputs = missing.iter().fold(outputs, |outputs, job| outputs.file("--out", &job.out));
    let copy = options.out.join(ARM);
    // The copy does not say who made it; the report beside it does.
    let is_new = !copy.exists() || file::read_text(&copy)? == text;
    let has_report = options.out.join("metrics.json").exists();
    let outputs = if is_new || has_report { outputs } else { outputs.file("--out", &copy) };
    let _claim = outputs.report("--out", Some(&options.out)).check(context)?;
    tracing::info!("{n_jobs} trajectories, {} of them are there already", rows.len());
    context.listen();
    let bar = context.progress("trajectories", n_jobs, rows.len());
    let found = parallel::try_map(&missing, |job| -> anyhow::Result<Option<Row>> {
        if context.is_cancelled() {
            return Ok(None);
        }
        let name = job.planned.name();
        let recording = arm.record(&job.planned.trial, options.seed, &name, job.meta.clone())?;
        recording.write(&job.out)?;
        let row = row(job, &recording)?;
        bar.inc(1);
        Ok(Some(row))
    })?;
    bar.finish();
    rows.extend(found.into_iter().flatten());
    if context.is_cancelled() {
        return Err(Cancelled::new(format!(
            "; {} of {n_jobs} trajectories are done: the same command goes on",
            rows.len()
        ))
        .into());
    }
    rows.sort_by(|a, b| a.name.cmp(&b.name));
    if !copy.exists() || file::read_text(&copy)? != text {
        file::write_bytes(&copy, &text)?;
    }
    let value = write_card(options, &arm, &rows, context)?;
    let samples: usize = rows.iter().map(|row| row.samples).sum();
    context.print(format_args!(
        "{} trajectories, {samples} samples (virtual arm, stand-in for NAD)",
        rows.len()
    ));
    context.reported(&options.out);
    Ok(value)
}

/// The arm and the text of its file.
pub(super) fn read_arm(named: &str) -> anyhow::Result<(VirtualArm, String)> {
    if let Some(text) = VirtualArm::preset_text(named) {
        return Ok((VirtualArm::preset(named)?, text.to_owned()));
    }
    if !named.contains(['.', '/']) && !Path::new(named).exists() {
        VirtualArm::preset(named)?;
    }
    let text = file::read_text(Path::new(named))?;
    Ok((VirtualArm::from_toml(&text, named)?, text))
}

/// The trajectories that are asked for.
fn selected(options: &Options) -> Result<Vec<Planned>, BadInput> {
    let nad = data_set();
    let mut own: Vec<&str> = nad.iter().map(|one| one.subset).collect();
    own.dedup();
    let all = [nad.clone(), fault_set()].concat();
    let mut subsets: Vec<&str> = all.iter().map(|one| one.subset).collect();
    subsets.dedup();
    known("--subsets", &options.subsets, &subsets)?;
    known("--splits", &options.splits, &SPLITS)?;
    let grams = |one: &Planned| (1e3 * one.trial.payload).round() as u32;
    if let Some(none) = options.payloads_g.iter().find(|wanted| all.iter().all(|one| grams(one) != **wanted))
    {
        let mut there: Vec<u32> = all.iter().map(grams).collect();
        there.sort_unstable();
        there.dedup();
        let there: Vec<String> = there.iter().map(u32::to_string).collect();
        return Err(BadInput::new("--payloads-g", format!("some of {}", there.join(", ")), none.to_string()));
    }
    let is_in = |wanted: &[String], name: &str| wanted.is_empty() || wanted.iter().any(|one| one == name);
    // What NAD does not have is asked for by name.
    let is_wanted = |name: &str| {
        if options.subsets.is_empty() { own.contains(&name) } else { is_in(&options.subsets, name) }
    };
    let mut tasks: Vec<&str> = all.iter().map(|one| one.task.as_str()).collect();
    tasks.dedup();
    if let Some(none) =
        options.tasks.iter().find(|wanted| !tasks.iter().any(|task| task.contains(wanted.as_str())))
    {
        let expected = format!("parts of names of tasks: {}", tasks.join(", "));
        return Err(BadInput::new("--tasks", expected, format!("\"{none}\"")));
    }
    let chosen: Vec<Planned> = all
        .iter()
        .filter(|one| is_wanted(one.subset) && is_in(&options.splits, one.split))
        .filter(|one| {
            options.tasks.is_empty() || options.tasks.iter().any(|part| one.task.contains(part.as_str()))
        })
        .filter(|one| options.payloads_g.is_empty() || options.payloads_g.contains(&grams(one)))
        .filter(|one| options.trajectories.is_none_or(|most| one.number <= most))
        .cloned()
        .collect();
    if chosen.is_empty() {
        return Err(BadInput::new("--subsets, --tasks, --splits, --payloads-g", "a trajectory", "none")
            .hint("no trajectory is in all that is asked for"));
    }
    Ok(chosen)
}

fn known(option: &str, wanted: &[String], there: &[&str]) -> Result<(), BadInput> {
    match wanted.iter().find(|name| !there.contains(&name.as_str())) {
        Some(name) => {
            Err(BadInput::new(option, format!("some of {}", there.join(", ")), format!("\"{name}\"")))
        }
        None => Ok(()),
    }
}

fn job(options: &Options, arm: &VirtualArm, planned: Planned, context: &Context) -> Job {
    let mut meta = super::meta(context, "");
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

fn row(job: &Job, recording: &Recording) -> Result<Row, BadInput> {
    let n = recording.n_samples();
    let labelled = recording.channel("force_z_labelled_ratio").unwrap_or(&[]);
    let said = |key: &str| recording.meta().extra.get(key).cloned().unwrap_or_default();
    Ok(Row {
        name: job.planned.name(),
        samples: n,
        duration_s: recording.time()[n - 1],
        labelled: labelled.iter().sum::<f64>() / n as f64,
        condition: said("condition"),
        payload_kg: job.planned.trial.payload,
    })
}

fn write_card(options: &Options, arm: &VirtualArm, rows: &[Row], context: &Context) -> anyhow::Result<Value> {
    let seconds: f64 = rows.iter().map(|row| row.duration_s).sum();
    let samples = rows.iter().map(|row| row.samples).sum();
    let card = Card {
        format: "hysteron-metrics",
        version: 1,
        about: ABOUT,
        arm: &arm.name,
        arm_sha256: &arm.hash,
        seed: options.seed,
        trajectories: rows.len(),
        samples,
        duration_min: seconds / 60.0,
        rows,
        command: &context.command,
        commit: COMMIT,
    };
    let value = write_metrics(&options.out, &card)?;
    let mut page = Page::new("Data set of the virtual arm", ABOUT, &context.command);
    page.heading("What it holds");
    page.list(vec![
        ("Virtual arm", arm.name.clone()),
        ("Seed", options.seed.to_string()),
        ("Trajectories", rows.len().to_string()),
        ("Samples", samples.to_string()),
        ("Duration [min]", format!("{:.1}", seconds / 60.0)),
    ]);
    page.heading("Tasks");
    let mut tasks: BTreeMap<&str, Vec<&Row>> = BTreeMap::new();
    for row in rows {
        let task = row.name.rsplitn(3, '/').last().unwrap_or(&row.name);
        tasks.entry(task).or_default().push(row);
    }
    let head = [
        "Task",
        "Payload [g]",
        "Condition",
        "Trajectories",
        "Samples",
        "Mean duration [s]",
        "Force labelled [% of rows]",
    ];
    page.table(&head, tasks.iter().map(|(task, rows)| cells(task, rows)));
    page.small(&format!("Arm {}.", arm.hash));
    write_page(&options.out, page.finish(COMMIT))?;
    Ok(value)
}

fn cells(task: &str, rows: &[&Row]) -> Vec<String> {
    let samples: usize = rows.iter().map(|row| row.samples).sum();
    let seconds: f64 = rows.iter().map(|row| row.duration_s).sum();
    let labelled: f64 = rows.iter().map(|row| row.labelled * row.samples as f64).sum();
    vec![
        task.to_owned(),
        format!("{:.0}", 1e3 * rows[0].payload_kg),
        rows[0].condition.clone(),
        rows.len().to_string(),
        samples.to_string(),
        format!("{:.1}", seconds / rows.len() as f64),
        format!("{:.0}", 100.0 * labelled / samples as f64),
    ]
}
