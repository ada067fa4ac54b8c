//! A run in memory: the rows that `simulate` writes, without files.

use std::path::Path;

use hysteron_base::{Metadata, Recording, Scene};
use hysteron_twin::command::{Command, CommandRollout};
use hysteron_twin::{Twin, TwinState};

use super::input::sample_duration;
use super::residual::ResidualTrace;
use super::rollout::{RunEnd, RunState, describe_sample, follow};
use super::run::check_network_drives;
use super::trace::Trace;
use crate::shared::error::Cancelled;
use crate::shared::memory;
use crate::shared::network::Network;
use crate::{COMMIT, Context, WorkflowError};

/// Place of the strokes in a message.
const STROKES: &str = "strokes";

/// The recording of a twin of `scene` that follows `strokes` from the equilibrium `start`, with the residual network of a
/// checkpoint where there is one, and the last equilibrium. Its rows are those of `simulate`. A network begins at rest, whatever
/// `start` is.
///
/// # Errors
/// Bad input; an interruption; a sample without a solution.
pub fn rollout(
    (scene, twin): (&Scene, &Twin),
    strokes: &Recording,
    start: &TwinState,
    residual: Option<&Path>,
    context: &Context,
) -> Result<(Recording, TwinState), WorkflowError> {
    Ok(follow_strokes((scene, twin), strokes, start, residual, context)?)
}

fn follow_strokes(
    (scene, twin): (&Scene, &Twin),
    strokes: &Recording,
    start: &TwinState,
    residual: Option<&Path>,
    context: &Context,
) -> anyhow::Result<(Recording, TwinState)> {
    let place = Path::new(STROKES);
    let command = Command::new(twin, strokes, place)?;
    let mut network = None;
    if let Some(path) = residual {
        check_network_drives(&command)?;
        network = Some(Network::read(path, scene, twin)?);
    }
    let corrected = match &network {
        Some(network) => Some(network.rollout(twin, sample_duration(strokes, place)?)?),
        None => None,
    };
    let mut residual = network.as_ref().map(|network| ResidualTrace::new(network.n_aux()));
    let n_samples = command.time.len();
    memory::check_result(place, n_samples, 4 + 2 * (twin.n_primary + twin.tendons.len()))?;
    let mut state = RunState::new(start.clone(), Trace::new(twin, n_samples));
    let mut rollout = CommandRollout::new(twin, &command, corrected, (start, 0))?;
    context.listen();
    let watched = (residual.as_mut(), None, None);
    let end = follow((twin, &command), &mut rollout, &mut state, watched, context)?;
    let RunState { twin: last, trace, .. } = state;
    match end {
        RunEnd::Done => {}
        RunEnd::Interrupted => return Err(Cancelled::new("; the rollout is not kept").into()),
        RunEnd::Failed(error) => {
            return Err(error.context(describe_sample(twin, &command, trace.len())));
        }
    }
    let further = residual.map_or_else(Vec::new, ResidualTrace::into_channels);
    let meta = Metadata {
        scene_hash: scene.hash.clone(),
        seed: Some(scene.seed),
        commit: COMMIT.to_owned(),
        source: format!("simulation of {} with strokes in memory", scene.name),
        command: context.command.clone(),
        ..Metadata::default()
    };
    Ok((trace.into_recording(twin, &command, further, meta)?, last))
}
