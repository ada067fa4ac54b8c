//! The recipe of a run: scene and recording in, recording, report and outcome out.

use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

use anyhow::Context as _;
use hysteron_base::{BadInput, Metadata, Recording, Scene, file};
use hysteron_control::score::score;
use hysteron_fem::{Mesh, MeshQuality};
use hysteron_report::folder::ReportFolder;
use hysteron_twin::command::{Command, CommandRollout};
use hysteron_twin::{LockedMove, LockingEstimator, RunLocking, Twin, TwinState};

use super::band::TipBandSummary;
use super::exact::ExactSamples;
use super::input::{RunInput, Task};
use super::options::RunOptions;
use super::outcome::{Outcome, Run};
use super::page;
use super::partial::Partial;
use super::residual::ResidualTrace;
use super::rollout::{RunEnd, RunState, follow};
use super::series::{self, Series};
use super::summary::RunSummary;
use super::trace::Trace;
use crate::Context;
use crate::shared::network::Network;
use crate::shared::outputs::Outputs;
use crate::shared::plan::angles_of;
use crate::shared::shapes::TipShapes;
use crate::shared::{locking, memory};

/// Makes a run through the recording at `path`, with the residual network of a checkpoint where there is one.
///
/// # Errors
/// Bad input; an interruption; a sample without a solution; files that cannot be written.
pub fn run(
    task: Task,
    path: &Path,
    options: &RunOptions,
    residual: Option<&Path>,
    context: &Context,
) -> anyhow::Result<Outcome> {
    let partial = Partial::of(&options.out)?;
    let scene = options.body.scene(&options.scene)?;
    let input = RunInput::read(task, path)?;
    let _lock = outputs(options, &scene, &input, residual, &partial).check(context)?;
    let (mesh, quality) = hysteron_twin::read_body(&scene)?;
    let twin = Twin::new(&scene, &mesh)?.with_body_of(&scene)?;
    let mut exact = ExactSamples::new(&twin, options.exact_every)?;
    let command = input.command(&twin)?;
    let mut provenance = input.provenance(&scene, context);
    if let Some(path) = &scene.reduced_path {
        provenance.extra.insert("chain_sha256".to_owned(), file::sha256_of(path)?);
    }
    let mut network = None;
    if let Some(path) = residual {
        check_residual(options, &command)?;
        provenance.extra.insert("residual_sha256".to_owned(), file::sha256_of(path)?);
        network = Some(Network::read(path, &scene, &twin)?);
    }
    let corrected = match &network {
        Some(network) => Some(network.rollout(&twin, input.sample_duration()?)?),
        None => None,
    };
    let mut residual = network.as_ref().map(|network| ResidualTrace::new(network.n_aux()));
    // Of every sample its tip, strokes and tensions, measured and commanded.
    let n_columns = 4 + 2 * (twin.n_primary + twin.tendons.len());
    memory::check_result(&input.path, input.samples.n_samples(), n_columns)?;
    let mut state = start(options, &partial, &twin, &provenance, &command)?;
    log(&scene, &twin, &command);
    input.warn();
    let predicted = predict_locking(&scene, (&mesh, &quality), task, &command)?;

    context.listen();
    let mut series = series_of(options, &twin, &command, state.trace.len())?;
    let n_earlier = state.trace.len();
    let mut rollout = CommandRollout::new(&twin, &command, corrected, (&state.twin, n_earlier))?;
    let robot = (&twin, &command);
    let traces = (residual.as_mut(), series.as_mut(), exact.as_mut());
    let end = follow(robot, &mut rollout, &mut state, traces, context)?;
    if let Some(mut series) = series {
        series.finish()?;
    }

    let RunState { twin: last, trace, mut summary } = state;
    let (farthest_row, farthest) = rollout.farthest();
    let n_done = trace.len();
    summary.extrapolated = residual.as_ref().map(ResidualTrace::extrapolated);
    summary.exact = exact.as_ref().and_then(ExactSamples::summary);
    summary.outside_validation =
        twin.chain.as_ref().map(|_| rollout.n_outside() as f64 / n_done.max(1) as f64);
    let further = residual.map_or_else(Vec::new, ResidualTrace::into_channels);
    let is_complete = matches!(end, RunEnd::Done);
    provenance.extra.insert("complete".to_owned(), is_complete.to_string());
    let recording = match n_done {
        0 => None,
        _ => Some(trace.into_recording(&twin, &command, further, provenance)?),
    };
    let (true, Some(recording)) = (is_complete, &recording) else {
        last.write(&partial.state, &twin, &scene.hash, &context.command)?;
        if let Some(recording) = &recording {
            recording.write(&partial.recording)?;
        }
        return Err(partial.stopped(end, n_done, &twin, &command));
    };
    sum_up(&mut summary, &input, (&twin, &command), recording, predicted.as_ref(), farthest);
    let band = network.as_ref().and_then(|network| network.model().training.tip_band.as_ref());
    summary.tip_band =
        band.and_then(|band| TipBandSummary::new(band, recording, input.measured(), input.samples.gap()));
    recording.write(&options.out)?;
    if let Some(path) = &options.save_state {
        last.write(path, &twin, &scene.hash, &context.command)?;
    }
    let done = Run {
        task,
        twin: &twin,
        scene: &scene,
        recording,
        goals: command.goals.as_ref(),
        measured: input.measured(),
        gap: input.samples.gap(),
        farthest: (farthest_row, farthest),
        summary: &summary,
    };
    let outcome = report(&done, options, context)?;
    if options.resume {
        partial.remove(options.save_state.as_ref())?;
    }
    summary.log();
    context.wrote(&options.out);
    Ok(outcome)
}

/// State that the run begins in: where an earlier one stopped, a state that was saved, or rest.
fn start(
    options: &RunOptions,
    partial: &Partial,
    twin: &Twin,
    provenance: &Metadata,
    command: &Command,
) -> anyhow::Result<RunState> {
    let trace = Trace::new(twin, command.time.len());
    if options.resume {
        return partial.resume(twin, provenance, command, trace);
    }
    let state = match &options.from {
        Some(path) => TwinState::read(path, twin, &provenance.scene_hash)?,
        None => twin.rest(),
    };
    Ok(RunState::new(state, trace))
}

/// Logs the size of the model and of the work.
fn log(scene: &Scene, twin: &Twin, command: &Command) {
    let n_samples = command.time.len();
    tracing::info!(
        "{}: {} nodes, {} tetrahedra, {} unknowns, {} tendons; {n_samples} samples over {:.2} s",
        scene.name,
        twin.body.n_nodes(),
        twin.body.cells.len(),
        twin.body.n_unknowns(),
        twin.tendons.len(),
        command.time[n_samples - 1] - command.time[0],
    );
}

/// Warns of a doubtful mesh, and estimates what linear tetrahedra will lose where the strokes are known.
fn predict_locking(
    scene: &Scene,
    (mesh, quality): (&Mesh, &MeshQuality),
    task: Task,
    command: &Command,
) -> anyhow::Result<Option<LockedMove>> {
    quality.warnings().iter().for_each(|warning| tracing::warn!("{warning}"));
    let estimator = LockingEstimator::new(scene, mesh)?;
    Ok(match task {
        Task::Simulate => {
            let farthest = estimator.farthest(command.time.len(), |row| command.targets(row));
            farthest.iter().for_each(locking::warn_of_recording);
            farthest
        }
        Task::Reach(_) => {
            locking::warn(&estimator);
            None
        }
    })
}

/// The series of pictures that was asked for, after `n_done` samples of an earlier run.
fn series_of(
    options: &RunOptions,
    twin: &Twin,
    command: &Command,
    n_done: usize,
) -> anyhow::Result<Option<Series>> {
    let Some(folder) = &options.vtu else { return Ok(None) };
    let every = options.vtu_every.map_or(command.time.len().div_ceil(200), NonZeroUsize::get);
    Series::new(folder, twin, every, &command.time[..n_done]).map(Some)
}

/// Adds to the numbers of a run what its recording shows.
fn sum_up(
    summary: &mut RunSummary,
    input: &RunInput,
    (twin, command): (&Twin, &Command),
    recording: &Recording,
    predicted: Option<&LockedMove>,
    farthest: &TwinState,
) {
    summary.finish(twin, recording, command.goals.as_ref());
    summary.locking = predicted.map(|predicted| {
        let moved = RunLocking::new(predicted, twin, farthest);
        locking::warn_of_run(&moved);
        moved
    });
    let tips = input.measured().zip(recording.tip());
    summary.against_measured = tips.map(|(tip, own)| score(tip, own, input.samples.gap()));
}

/// The outcome of a run, and its report where one was asked for.
fn report(run: &Run, options: &RunOptions, context: &Context) -> anyhow::Result<Outcome> {
    let shapes = shapes(run);
    let outcome = Outcome::new(run, shapes.as_ref().map_or(vec![], TipShapes::numbers));
    if let Some(folder) = &options.figures {
        page::write(&ReportFolder { path: folder, png: options.png }, run, &outcome, shapes.as_ref())
            .with_context(|| format!("writing figures to {}", folder.display()))?;
        context.reported(folder);
    }
    Ok(outcome)
}

/// Command and tip of a run that followed strokes, where the tendons bend in two directions and something moved.
fn shapes(run: &Run) -> Option<TipShapes> {
    match run.task {
        Task::Simulate => TipShapes::new(&angles_of(run.scene), &[(&run.scene.name, run.recording)]).ok(),
        Task::Reach(_) => None,
    }
}

/// Files that a run reads and those that it may write, whole or partial.
fn outputs(
    options: &RunOptions,
    scene: &Scene,
    input: &RunInput,
    checkpoint: Option<&Path>,
    partial: &Partial,
) -> Outputs {
    let mut outputs = Outputs::reading([&input.path])
        .scene(&options.scene, scene)
        .and(checkpoint)
        .and(&options.from)
        .file("--out", &options.out)
        .report("--figures", options.figures.as_deref());
    // The files of a resumed run are checked when they are read, and a state that is saved may have the name of that file.
    let is_new = |file: &&PathBuf| !options.resume && options.save_state.as_ref() != Some(*file);
    for file in partial.files().into_iter().filter(is_new) {
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

/// The network remembers, and its memory is not saved: a run with it starts from rest.
fn check_residual(options: &RunOptions, command: &Command) -> Result<(), BadInput> {
    let start = if options.resume { Some("--resume") } else { options.from.as_ref().map(|_| "--from") };
    if let Some(start) = start {
        return Err(BadInput::new("--residual", "a run from rest", start)
            .hint("the memory of the network is no part of a state"));
    }
    check_network_drives(command)
}

/// The network takes the strokes of all primary tendons, and alone drives the auxiliary ones.
pub fn check_network_drives(command: &Command) -> Result<(), BadInput> {
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
