//! A run: a robot goes through the samples of a recording, from files to files.
//!
//! Nothing partial ever stands under the final name. A run that fails or is interrupted leaves what it has as
//! `<out>.partial.<ext>` with the last equilibrium beside it as `<out>.state`, from which `--resume` goes on. What
//! the robot does in a sample is the one difference between the verbs: it follows strokes, or reaches for a goal.

mod command;
mod figures;
mod goals;
mod outcome;
mod page;
mod residual;
mod series;
mod summary;
mod trace;

use std::collections::BTreeMap;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::Context as _;
use hysteron_base::{BadInput, Metadata, Recording, Scene, file};
use hysteron_control::score::score;
use hysteron_report::folder::ReportFolder;
use hysteron_twin::{Stepper, Twin, TwinState};

use crate::shared::error::Cancelled;
use crate::shared::locking::{Estimator, RunLocking, tip_distance};
use crate::shared::memory;
use crate::shared::network::Network;
use crate::shared::outputs::Outputs;
use crate::shared::paths;
use crate::shared::plan::angles_of;
use crate::shared::shapes::TipShapes;
use crate::{COMMIT, Context};
use command::Command;
pub use command::resting;
pub use goals::Goals;
pub use outcome::{Outcome, Run, Task};
use residual::Residual;
use series::Series;
pub use summary::RunSummary;
use trace::Trace;

/// Scene and outputs, the same for every verb that makes a run.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct RunOptions {
    /// Scene file of the robot (scene.toml)
    pub scene: PathBuf,
    /// Recording to write, .parquet or .csv
    #[cfg_attr(feature = "clap", arg(long, value_name = "REC"))]
    pub out: PathBuf,
    /// Folder for figures, report.html and metrics.json
    #[cfg_attr(feature = "clap", arg(long, value_name = "DIR"))]
    pub figures: Option<PathBuf>,
    /// Write each figure as .png too
    #[cfg_attr(feature = "clap", arg(long, requires = "figures"))]
    pub png: bool,
    /// Folder for a ParaView series (open robot.pvd): body and tendons
    #[cfg_attr(feature = "clap", arg(long, value_name = "DIR"))]
    pub vtu: Option<PathBuf>,
    /// Every how many samples the series has a picture [default: 200 pictures in all]
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", requires = "vtu"))]
    pub vtu_every: Option<NonZeroUsize>,
    /// Start from this state of the same scene instead of from rest
    #[cfg_attr(feature = "clap", arg(long, value_name = "STATE", conflicts_with = "resume"))]
    pub from: Option<PathBuf>,
    /// Go on with the run of this OUT that failed or was interrupted
    #[cfg_attr(feature = "clap", arg(long))]
    pub resume: bool,
    /// Save the last state here, for --from
    #[cfg_attr(feature = "clap", arg(long, value_name = "STATE"))]
    pub save_state: Option<PathBuf>,
}

/// Model that moves the robot from sample to sample.
enum Driver<'a, 'b> {
    Stepper(Box<Stepper>),
    Network(&'a mut Residual<'b>),
}

/// How a run ended.
enum End {
    Done,
    Interrupted,
    Failed(anyhow::Error),
}

/// Makes a run through the recording `input`, with the residual network of a checkpoint if there is one.
pub fn run(
    task: Task,
    input: &Path,
    options: &RunOptions,
    checkpoint: Option<&Path>,
    context: &Context,
) -> anyhow::Result<Outcome> {
    let (partial, state_file) = check_out(&options.out)?;
    let scene = Scene::read(&options.scene)?;
    let samples = Recording::read(input)?;
    let _claim = outputs(options, &scene, input, checkpoint, [&partial, &state_file]).check(context)?;
    let (mesh, quality) = hysteron_twin::read_body(&scene)?;
    let twin = Twin::new(&scene, &mesh)?;
    let command = match task {
        Task::Simulate => Command::new(&twin, &samples, input)?,
        Task::Reach(tolerance) => {
            Command::with_free_strokes(&twin, &samples, input, Goals::new(&samples, input, tolerance)?)?
        }
    };
    let mut provenance = provenance(&scene, task, input, context)?;
    let network = match checkpoint {
        Some(path) => {
            check_residual(options, &command)?;
            provenance.extra.insert("residual_sha256".to_owned(), file::sha256_of(path)?);
            Some(Network::read(path, &scene, &twin)?)
        }
        None => None,
    };
    let mut residual = match &network {
        Some(network) => Some(Residual::new(network, &twin, sample_duration(&samples, input)?)?),
        None => None,
    };

    // Of every sample its tip, strokes and tensions, with what they were told to be.
    let n_columns = 4 + 2 * (twin.n_primary + twin.tendons.len());
    memory::check_result(input, samples.n_samples(), n_columns)?;
    let mut trace = Trace::new(&twin, samples.n_samples());
    let mut state = match &options.from {
        Some(path) => TwinState::read(path, &twin, &scene.hash)?,
        None => twin.rest(),
    };
    if options.resume {
        state = resume(&partial, &state_file, &twin, &scene, &provenance, &command, &mut trace)?;
    }
    tracing::info!(
        "{}: {} nodes, {} tetrahedra, {} unknowns, {} tendons; {} samples over {:.2} s",
        scene.name,
        twin.body.n_nodes(),
        twin.body.cells.len(),
        twin.body.n_unknowns(),
        twin.tendons.len(),
        samples.n_samples(),
        command.time[samples.n_samples() - 1] - command.time[0],
    );
    if !is_uniform(&samples) {
        tracing::warn!("{}: the time steps differ by more than 1 %", input.display());
    }

    quality.warnings().iter().for_each(|warning| tracing::warn!("{warning}"));
    let estimator = Estimator::new(&scene, &mesh)?;
    let foreseen = match task {
        Task::Simulate => estimator.foresee(samples.n_samples(), |row| {
            let mut targets = Vec::new();
            command.targets_into(row, &mut targets);
            targets
        }),
        Task::Reach(_) => {
            estimator.warn();
            None
        }
    };

    context.listen();
    let mut series = match &options.vtu {
        Some(folder) => {
            let every = options.vtu_every.map_or(samples.n_samples().div_ceil(200), NonZeroUsize::get);
            Some(Series::new(folder, &twin, every, &command.time[..trace.len()])?)
        }
        None => None,
    };
    let mut summary = RunSummary::default();
    let mut farthest = (trace.len(), state.clone());
    let mut driver = match &mut residual {
        Some(residual) => Driver::Network(residual),
        None => {
            let mut stepper = Stepper::new(&twin);
            stepper.restore(&twin, &state)?;
            Driver::Stepper(Box::new(stepper))
        }
    };
    let end = follow(
        &twin,
        &command,
        &mut driver,
        &mut state,
        &mut trace,
        &mut summary,
        &mut farthest,
        series.as_mut(),
        context,
    )?;
    if let Some(mut series) = series {
        series.finish()?;
    }

    let is_complete = matches!(end, End::Done);
    let stopped_at = trace.len();
    summary.extrapolated = residual.as_ref().map(Residual::extrapolated);
    let further = residual.map_or_else(Vec::new, |residual| residual.into_channels(stopped_at));
    let recording = if stopped_at == 0 {
        None
    } else {
        Some(trace.into_recording(&twin, &command, further, with_completeness(provenance, is_complete))?)
    };
    let (End::Done, Some(recording)) = (&end, &recording) else {
        state.write(&state_file, &twin, &scene.hash, &context.command)?;
        if let Some(recording) = &recording {
            recording.write(&partial)?;
        }
        return Err(stopped(end, stopped_at, &twin, &command, &partial, &state_file));
    };
    let measured = samples.tip().filter(|_| task == Task::Simulate);
    summary.finish(&twin, recording, command.goals.as_ref());
    summary.locking = foreseen.map(|foreseen| {
        let moved = RunLocking::new(&foreseen, tip_distance(&twin, &farthest.1));
        moved.warn();
        moved
    });
    summary.against_measured = measured.zip(recording.tip()).map(|(tip, own)| score(tip, own, samples.gap()));
    recording.write(&options.out)?;
    if let Some(path) = &options.save_state {
        state.write(path, &twin, &scene.hash, &context.command)?;
    }
    let run = Run {
        task,
        twin: &twin,
        scene: &scene,
        recording,
        goals: command.goals.as_ref(),
        measured,
        gap: samples.gap(),
        farthest: (farthest.0, &farthest.1),
        summary: &summary,
    };
    let shapes = shapes(&run);
    let outcome = Outcome::new(&run, shapes.as_ref().map_or(vec![], TipShapes::numbers));
    if let Some(folder) = &options.figures {
        let report = ReportFolder { path: folder, png: options.png };
        page::write(&report, &run, &outcome, shapes.as_ref())
            .with_context(|| format!("writing figures to {}", folder.display()))?;
        context.reported(folder);
    }
    if options.resume {
        let is_left = |path: &&PathBuf| options.save_state.as_ref() != Some(*path);
        for path in [&partial, &state_file].into_iter().filter(is_left) {
            std::fs::remove_file(path).with_context(|| format!("removing {}", path.display()))?;
        }
    }
    summary.log();
    context.wrote(&options.out);
    Ok(outcome)
}

/// Command and tip of a run that followed strokes, where the tendons bend in two directions and something moved.
fn shapes(run: &Run) -> Option<TipShapes> {
    match run.task {
        Task::Simulate => TipShapes::new(&angles_of(run.scene), &[(&run.scene.name, run.recording)]).ok(),
        Task::Reach(_) => None,
    }
}

/// Steps through the samples that `trace` does not have yet.
#[expect(clippy::too_many_arguments, reason = "each is one of the things a run reads or writes")]
fn follow(
    twin: &Twin,
    command: &Command,
    driver: &mut Driver,
    state: &mut TwinState,
    trace: &mut Trace,
    summary: &mut RunSummary,
    farthest: &mut (usize, TwinState),
    mut series: Option<&mut Series>,
    context: &Context,
) -> anyhow::Result<End> {
    let mut targets = Vec::new();
    let rest = twin.tip_of(&twin.rest());
    let distance = |tip: [f64; 3]| (0..3).map(|c| (tip[c] - rest[c]).powi(2)).sum::<f64>();
    let mut largest = f64::NEG_INFINITY;
    let bar = context.progress("samples", command.time.len(), trace.len());
    let start = Instant::now();
    let mut end = End::Done;
    let mut before = state.clone();
    for row in trace.len()..command.time.len() {
        if context.is_cancelled() {
            end = End::Interrupted;
            break;
        }
        command.targets_into(row, &mut targets);
        let step = match (&command.goals, &mut *driver) {
            (_, Driver::Network(residual)) => {
                residual.step(&command.primary_strokes(row), state).map(|step| (step.report, step.tip))
            }
            (goals, Driver::Stepper(stepper)) => {
                let step = match goals {
                    None => stepper.step(twin, &targets),
                    Some(goals) => stepper.reach(twin, &goals.tip_goal(row), &targets).map(|reach| {
                        summary.rounds += reach.rounds;
                        reach.step
                    }),
                };
                state.clone_from(stepper.state());
                step.map(|report| (report, twin.tip_of(state)))
            }
        };
        let step = step.map_err(anyhow::Error::from).and_then(|(report, tip)| {
            summary.add(&report);
            command.overloaded(twin, state).map_or(Ok(tip), Err)
        });
        let tip = match step {
            Ok(tip) => tip,
            Err(error) => {
                // Back to the last sample, so that state and recording agree.
                state.clone_from(&before);
                end = End::Failed(error);
                break;
            }
        };
        before.clone_from(state);
        trace.push(twin, state, tip);
        if distance(tip) > largest {
            largest = distance(tip);
            farthest.0 = row;
            farthest.1.clone_from(state);
        }
        if let Some(series) = &mut series {
            series.add(twin, state, row, command.time[row])?;
        }
        bar.inc(1);
    }
    summary.wall_s = start.elapsed().as_secs_f64();
    bar.finish();
    Ok(end)
}

/// The error of a run that did not reach its end.
fn stopped(
    end: End,
    n_done: usize,
    twin: &Twin,
    command: &Command,
    partial: &Path,
    state_file: &Path,
) -> anyhow::Error {
    let kept = if n_done == 0 {
        format!("the last equilibrium is in {}", state_file.display())
    } else {
        format!(
            "{n_done} of {} samples are in {}, the last equilibrium in {}",
            command.time.len(),
            partial.display(),
            state_file.display()
        )
    };
    match end {
        End::Failed(error) => anyhow::anyhow!(
            "row {} (t = {} s), tendons {}: {error:#}; {kept}",
            n_done + 1,
            hysteron_base::number::shown(command.time[n_done]),
            command.describe(twin, n_done),
        ),
        _ => Cancelled::new(format!("; {kept}; add --resume to go on")).into(),
    }
}

/// Files that a run reads and those that it may write, whole or partial.
fn outputs(
    options: &RunOptions,
    scene: &Scene,
    input: &Path,
    checkpoint: Option<&Path>,
    partial: [&PathBuf; 2],
) -> Outputs {
    let mut outputs = Outputs::reading([input])
        .scene(&options.scene, scene)
        .and(checkpoint)
        .and(&options.from)
        .file("--out", &options.out)
        .report("--figures", options.figures.as_deref());
    // What a run goes on from is checked when it is read, and a state that is saved may have the name of that file.
    for file in
        partial.into_iter().filter(|file| !options.resume && options.save_state.as_ref() != Some(*file))
    {
        outputs = outputs.file("--out", file);
    }
    if let Some(file) = &options.save_state {
        outputs = outputs.file("--save-state", file);
    }
    if let Some(folder) = &options.vtu {
        outputs = outputs.folder("--vtu", folder);
        for file in series::there(folder) {
            outputs = outputs.file("--vtu", file);
        }
    }
    outputs
}

/// Checks the name to write and gives those of the partial recording and the state.
fn check_out(out: &Path) -> Result<(PathBuf, PathBuf), BadInput> {
    let extension = paths::check_recording(out)?;
    Ok((out.with_extension(format!("partial.{extension}")), out.with_extension("state")))
}

/// The network remembers, and its memory is not saved: a run with it starts from rest.
fn check_residual(options: &RunOptions, command: &Command) -> Result<(), BadInput> {
    let start = if options.resume { Some("--resume") } else { options.from.as_ref().map(|_| "--from") };
    if let Some(start) = start {
        return Err(BadInput::new("--residual", "a run from rest", start)
            .hint("the memory of the network is no part of a state"));
    }
    if command.primary_strokes(0).len() != command.n_primary {
        return Err(BadInput::new(
            "--residual",
            "a scene that drives all tendons by stroke",
            "another drive",
        ));
    }
    if command.drives_auxiliary {
        return Err(BadInput::new("aux columns", "none: the network drives the auxiliary tendons", "some")
            .hint("leave out --residual to follow them"));
    }
    Ok(())
}

/// Duration of a sample [s], all the same.
fn sample_duration(samples: &Recording, input: &Path) -> Result<f64, BadInput> {
    samples.rate_hz().map(f64::recip).ok_or_else(|| {
        BadInput::new(format!("{}: time_s", input.display()), "a fixed rate, for the network", "uneven steps")
            .hint("resample the commands")
    })
}

/// Metadata of the recording: its provenance.
fn provenance(scene: &Scene, task: Task, input: &Path, context: &Context) -> anyhow::Result<Metadata> {
    let hash = file::sha256_of(input)?;
    let mut extra = BTreeMap::from([(format!("{}_sha256", task.input()), hash)]);
    let source = match task {
        Task::Simulate => format!("simulation of {} with strokes from {}", scene.name, input.display()),
        Task::Reach(tolerance) => {
            extra.insert("tolerance_m".to_owned(), tolerance.to_string());
            format!("strokes of {} for the tip positions in {}", scene.name, input.display())
        }
    };
    Ok(Metadata {
        scene_hash: scene.hash.clone(),
        seed: Some(scene.seed),
        commit: COMMIT.to_owned(),
        source,
        command: context.command.clone(),
        extra,
    })
}

fn with_completeness(mut meta: Metadata, is_complete: bool) -> Metadata {
    meta.extra.insert("complete".to_owned(), is_complete.to_string());
    meta
}

/// Reads where an earlier run stopped: fills `trace` and returns the state.
fn resume(
    partial: &Path,
    state_file: &Path,
    twin: &Twin,
    scene: &Scene,
    provenance: &Metadata,
    command: &Command,
    trace: &mut Trace,
) -> anyhow::Result<TwinState> {
    if !partial.exists() {
        return Err(BadInput::new(
            partial.display().to_string(),
            "the partial recording of an earlier run with the same --out",
            "nothing there",
        )
        .hint("leave out --resume to start anew")
        .into());
    }
    let earlier = Recording::read(partial)?;
    let bad = |what: &str, expected: &str, found: &str| {
        BadInput::new(format!("{}: {what}", partial.display()), expected, found)
            .hint("leave out --resume to start anew")
    };
    if earlier.meta().scene_hash != scene.hash {
        return Err(bad("scene_hash", &scene.hash, &earlier.meta().scene_hash).into());
    }
    for (key, expected) in &provenance.extra {
        let found = earlier.meta().extra.get(key).map_or("", String::as_str);
        if found != expected {
            return Err(bad(key, expected, found).into());
        }
    }
    if !command.time.starts_with(earlier.time()) {
        return Err(bad("time_s", "the first times of the recording to follow", "others").into());
    }
    let state = TwinState::read(state_file, twin, &scene.hash)?;
    trace.extend(&earlier).map_err(|error| error.within(partial.display()))?;
    Ok(state)
}

fn is_uniform(recording: &Recording) -> bool {
    recording.n_samples() < 3 || recording.rate_hz().is_some()
}
