//! The loop of a run: sample by sample, until its end, an interruption or an error.

use std::time::{Duration, Instant};

use hysteron_base::number;
use hysteron_twin::command::{Command, CommandRollout};
use hysteron_twin::{Twin, TwinState};

use super::exact::ExactSamples;
use super::residual::ResidualTrace;
use super::series::Series;
use super::summary::RunSummary;
use super::trace::Trace;
use crate::Context;

/// Everything that changes from sample to sample.
pub struct RunState {
    /// Equilibrium of the last sample.
    pub twin: TwinState,
    /// The recording so far.
    pub trace: Trace,
    /// Cost and accuracy so far.
    pub summary: RunSummary,
}

/// A sample in words: its row from 1, its time and what was commanded.
pub fn describe_sample(twin: &Twin, command: &Command, row: usize) -> String {
    let (at, tendons) = (number::shown(command.time[row]), command.describe(twin, row));
    format!("row {} (t = {at} s), tendons {tendons}", row + 1)
}

/// How a run ended.
pub enum RunEnd {
    /// It has all samples.
    Done,
    /// It was stopped from outside.
    Interrupted,
    /// A sample has no solution.
    Failed(anyhow::Error),
}

impl RunState {
    /// From an equilibrium, after the samples that `trace` has.
    pub fn new(twin: TwinState, trace: Trace) -> Self {
        Self { twin, trace, summary: RunSummary::default() }
    }
}

/// Followers of a run, where there are any: the record of the network, pictures, comparisons with the finite elements.
pub type Watched<'a> = (Option<&'a mut ResidualTrace>, Option<&'a mut Series>, Option<&'a mut ExactSamples>);

/// Steps through the samples that `run` does not have yet.
pub fn follow(
    (twin, command): (&Twin, &Command),
    rollout: &mut CommandRollout,
    run: &mut RunState,
    (mut residual, mut series, mut exact): Watched,
    context: &Context,
) -> anyhow::Result<RunEnd> {
    let bar = context.progress("samples", command.time.len(), run.trace.len());
    let start = Instant::now();
    let mut end = RunEnd::Done;
    for row in run.trace.len()..command.time.len() {
        if context.is_cancelled() {
            end = RunEnd::Interrupted;
            break;
        }
        if let Some(exact) = &mut exact {
            exact.begin(row, rollout.state());
        }
        let step = match rollout.step(row) {
            Ok(step) => step,
            Err(error) => {
                end = RunEnd::Failed(error.into());
                break;
            }
        };
        run.summary.add(&step);
        run.trace.push(rollout.state(), &step.strokes, step.tip);
        if let (Some(residual), Some(strokes)) = (&mut residual, rollout.network_strokes()) {
            residual.push(strokes, &step);
        }
        if let Some(exact) = &mut exact {
            exact.compare(twin, rollout.state(), &step)?;
        }
        if let Some(series) = &mut series {
            series.add(twin, rollout.state(), row, command.time[row])?;
        }
        bar.inc(1);
    }
    run.twin.clone_from(rollout.state());
    let compared = exact.map_or(Duration::ZERO, |exact| exact.spent);
    run.summary.wall_s = start.elapsed().saturating_sub(compared).as_secs_f64();
    bar.finish();
    Ok(end)
}
