//! Chooses what to estimate with, and where telemetry comes from.

use std::path::Path;

use hysteron_arm_learning::lagrangian::LearnedDynamics;
use hysteron_arm_learning::neural::{LiveEstimator, NeuralActuator};
use hysteron_base::BadInput;

use super::outcome::{LiveEstimates, RecordingEstimates, TelemetryEstimates};
use super::{Options, Outcome, along, external, live};
use crate::arm::{self, robot::held_joints};
use crate::{Context, WorkflowError};

/// Runs the verb.
///
/// # Errors
/// Bad input; files that cannot be written; arms that do not answer.
pub fn run(options: &Options, context: &Context) -> Result<Outcome, WorkflowError> {
    Ok(estimate(options, context)?)
}

fn estimate(options: &Options, context: &Context) -> anyhow::Result<Outcome> {
    let source = match (&options.live, &options.recording) {
        (Some(arms), _) => Source::Live(arms),
        (None, Some(recording)) => Source::Recording(recording),
        (None, None) => {
            return Err(BadInput::new("arguments", "a recording or --live FILE", "neither").into());
        }
    };
    let expected = "an actuator by hysteron arm fit neural, or a model by hysteron arm fit delan";
    arm::refuse_robot(&options.actuator, expected, "--robot takes the robot")?;
    if LearnedDynamics::is_file(&options.actuator) {
        return external::run(options, context).map(Outcome::External);
    }
    let read = [Some(&options.actuator), options.recording.as_ref(), options.live.as_ref()];
    let outputs = arm::reads(&options.robot).and(read.into_iter().flatten().cloned());
    let outputs = outputs.recording("--out", &options.out);
    // A recording from a bus has a lock of its own.
    let _lock = options.live.is_none().then(|| outputs.check(context)).transpose()?;
    let actuator = NeuralActuator::read(&options.actuator)?;
    let robot = options.robot_options.model(&options.robot, context)?;
    let model = actuator.observed_arm(&robot)?;
    let estimator = LiveEstimator::new(&actuator, &model);
    let estimator = estimator.map_err(|bad| bad.within(options.actuator.display()))?;
    let estimates = match source {
        Source::Live(arms) => {
            let found = live::run((options, arms), &actuator, estimator, context)?;
            let held_joints = held_joints(&robot);
            TelemetryEstimates::Live(Box::new(LiveEstimates { held_joints, ..found }))
        }
        Source::Recording(path) => {
            let found = along::run((options, path), &actuator, estimator, context)?;
            TelemetryEstimates::Along(RecordingEstimates { held_joints: held_joints(&robot), ..found })
        }
    };
    Ok(Outcome::Telemetry(estimates))
}

/// Source of the telemetry.
enum Source<'a> {
    /// The file of both arms on a bus.
    Live(&'a Path),
    Recording(&'a Path),
}
