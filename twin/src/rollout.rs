//! Whole command sequences, one or many at a time.

use hysteron_base::parallel;

use crate::model::{Target, Twin};
use crate::report::StepReport;
use crate::stepper::Stepper;
use crate::{Result, TwinState};

/// The answer to a command sequence: one entry per sample.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Rollout {
    /// Tip [m].
    pub tips: Vec<[f64; 3]>,
    /// Tension of every tendon [N].
    pub tensions: Vec<Vec<f64>>,
    /// Cost and accuracy of every step.
    pub reports: Vec<StepReport>,
}

/// Runs one sequence of commands (per sample, a target per tendon) from `start`.
///
/// # Errors
/// Those of [`Stepper::step`] at the first sample that fails.
pub fn rollout(twin: &Twin, start: &TwinState, commands: &[Vec<Target>]) -> Result<Rollout> {
    run(twin, Stepper::new(twin), start, commands)
}

/// Runs many sequences in parallel, on rayon's threads. Every rollout starts from fresh scratch, so its
/// result is the same to the last bit on any number of threads.
pub fn rollouts(twin: &Twin, start: &TwinState, sequences: &[Vec<Vec<Target>>]) -> Vec<Result<Rollout>> {
    let fresh = Stepper::new(twin);
    parallel::map(sequences, |commands| run(twin, fresh.clone(), start, commands))
}

fn run(twin: &Twin, mut stepper: Stepper, start: &TwinState, commands: &[Vec<Target>]) -> Result<Rollout> {
    stepper.restore(twin, start)?;
    let mut rollout = Rollout::default();
    for targets in commands {
        rollout.reports.push(stepper.step(twin, targets)?);
        let state = stepper.state();
        rollout.tips.push(twin.tip_of(state));
        rollout.tensions.push(state.tensions[..twin.tendons.len()].to_vec());
    }
    Ok(rollout)
}
