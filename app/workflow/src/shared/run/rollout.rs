//! The loop of a run: sample by sample, until its end, an interruption or an error.

use std::time::Instant;

use hysteron_twin::{Stepper, Twin, TwinState};

use super::command::Command;
use super::residual::Residual;
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
    /// State in which the tip was farthest from rest, and its sample.
    pub farthest: (usize, TwinState),
    /// Samples in which a chain was bent further than it was validated.
    pub n_outside: usize,
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

/// Model that moves the robot from sample to sample.
enum Driver<'a, 'b> {
    Stepper(Box<Stepper>),
    Network(&'a mut Residual<'b>),
}

impl RunState {
    /// From an equilibrium, after the samples that `trace` has.
    pub fn new(twin: TwinState, trace: Trace) -> Self {
        let farthest = (trace.len(), twin.clone());
        Self { twin, trace, summary: RunSummary::default(), farthest, n_outside: 0 }
    }
}

impl<'a, 'b> Driver<'a, 'b> {
    /// From an equilibrium of the twin; a network begins at rest.
    fn new(twin: &Twin, residual: Option<&'a mut Residual<'b>>, start: &TwinState) -> anyhow::Result<Self> {
        Ok(match residual {
            Some(residual) => Self::Network(residual),
            None => {
                let mut stepper = Stepper::new(twin);
                stepper.restore(twin, start)?;
                Self::Stepper(Box::new(stepper))
            }
        })
    }

    /// Moves the robot to the equilibrium of sample `row`; gives the tip and the strokes that servos show [m].
    fn step(
        &mut self,
        twin: &Twin,
        command: &Command,
        row: usize,
        run: &mut RunState,
    ) -> anyhow::Result<([f64; 3], Vec<f64>)> {
        let (report, tip, strokes) = match self {
            Self::Network(residual) => {
                let step = residual.step(&command.primary_strokes(row), &mut run.twin)?;
                (step.report, step.tip, twin.commands_of(&run.twin))
            }
            Self::Stepper(stepper) => {
                let targets = command.targets(row);
                let step = match &command.goals {
                    None => stepper.step(twin, &targets),
                    Some(goals) => stepper.reach(twin, &goals.tip_goal(row), &targets).map(|reach| {
                        run.summary.rounds += reach.rounds;
                        reach.step
                    }),
                };
                run.twin.clone_from(stepper.state());
                (step?, twin.tip_of(&run.twin), stepper.commands(twin))
            }
        };
        run.n_outside += usize::from(report.outside > 0.0);
        run.summary.add(&report);
        command.overloaded(twin, &run.twin).map_or(Ok((tip, strokes)), Err)
    }
}

/// Steps through the samples that `run` does not have yet.
pub fn follow(
    twin: &Twin,
    command: &Command,
    residual: Option<&mut Residual>,
    run: &mut RunState,
    mut series: Option<&mut Series>,
    context: &Context,
) -> anyhow::Result<RunEnd> {
    let mut driver = Driver::new(twin, residual, &run.twin)?;
    let rest = twin.tip_of(&twin.rest());
    let distance = |tip: [f64; 3]| (0..3).map(|c| (tip[c] - rest[c]).powi(2)).sum::<f64>();
    let mut largest = f64::NEG_INFINITY;
    let bar = context.progress("samples", command.time.len(), run.trace.len());
    let start = Instant::now();
    let mut end = RunEnd::Done;
    let mut before = run.twin.clone();
    for row in run.trace.len()..command.time.len() {
        if context.is_cancelled() {
            end = RunEnd::Interrupted;
            break;
        }
        let (tip, strokes) = match driver.step(twin, command, row, run) {
            Ok(found) => found,
            Err(error) => {
                // Back to the last sample, so that state and recording agree.
                run.twin.clone_from(&before);
                end = RunEnd::Failed(error);
                break;
            }
        };
        run.trace.push(&run.twin, &strokes, tip);
        before.clone_from(&run.twin);
        if distance(tip) > largest {
            largest = distance(tip);
            run.farthest.0 = row;
            run.farthest.1.clone_from(&run.twin);
        }
        if let Some(series) = &mut series {
            series.add(twin, &run.twin, row, command.time[row])?;
        }
        bar.inc(1);
    }
    run.summary.wall_s = start.elapsed().as_secs_f64();
    bar.finish();
    Ok(end)
}
