//! Adapts a neural actuator to recordings of an arm that has changed.

use std::path::PathBuf;

use hysteron_arm_dynamics::Model;
use hysteron_arm_learning::neural::{
    NeuralActuator, TelemetrySource, Trajectory, Unlabelled, pose_scores, roll_out, trajectory_of,
};
use hysteron_base::checks::{CheckContext, Purpose};
use hysteron_base::{BadInput, parallel};
use hysteron_learn::TrainingProgress;
use hysteron_report::verdict::{Criterion, Verdict};

use super::{Options, Outcome};
use crate::arm::{self, robot::held_joints};
use crate::shared::error::Cancelled;
use crate::shared::{recording_checks, verdict};
use crate::{Context, WorkflowError};

/// Runs the verb.
///
/// # Errors
/// Bad input; files that cannot be written; an interruption.
pub fn run(options: &Options, context: &Context) -> Result<Outcome, WorkflowError> {
    Ok(adapt(options, context)?)
}

fn adapt(options: &Options, context: &Context) -> anyhow::Result<Outcome> {
    arm::refuse_robot(
        &options.actuator,
        "an actuator by hysteron arm fit neural",
        "--robot takes the robot",
    )?;
    let outputs = arm::reads(&options.robot).and([&options.actuator]).and(&options.recordings);
    let _lock = outputs.learned("--out", &options.out).check(context)?;
    let actuator = NeuralActuator::read(&options.actuator)?;
    let model = options.robot_options.model(&options.robot, context)?;
    context.listen();
    let ranges = recording_checks::joint_ranges(&model);
    let checks = CheckContext { joint_ranges: &ranges, ..CheckContext::new(Purpose::Fit) };
    let findings = recording_checks::of_files(&options.recordings, &checks)?;
    let read = |path: &PathBuf| -> anyhow::Result<Trajectory> {
        let recording = crate::shared::memory::recording(path)?;
        let period = actuator.simulation.period;
        let found = trajectory_of(&recording, &actuator.features, period, Unlabelled::Unknown);
        Ok(found.map_err(|bad: BadInput| bad.within(path.display()))?)
    };
    let trajectories = options.recordings.iter().map(read).collect::<anyhow::Result<Vec<_>>>()?;
    let bar = context.progress("updates", options.updates, 0);
    let mut progress = |p: &TrainingProgress| {
        if let TrainingProgress::Epoch(epoch) = p {
            bar.set_message(format!("joints {:.3}°, best {:.3}°", epoch.validation, epoch.best));
        }
        bar.inc(1);
        !context.is_cancelled()
    };
    let about = (options.updates as u64, &mut progress as &mut dyn FnMut(&TrainingProgress) -> bool);
    let mut adapted = actuator.adapted(&model, &trajectories, about)?;
    bar.finish();
    if context.is_cancelled() {
        return Err(Cancelled::new("; nothing is written").into());
    }
    let errors = [&actuator, &adapted].map(|one| error(one, &model, &trajectories));
    let [before, after] = [errors[0].clone()?, errors[1].clone()?];
    let names: Vec<String> = options.recordings.iter().map(|path| path.display().to_string()).collect();
    adapted.details.adapted_to = names;
    adapted.details.provenance = Some(context.provenance());
    adapted.write(&options.out)?;
    context.print(format_args!(
        "joints in pure simulation of these recordings: {before:.3}° before, {after:.3}° after (mean absolute error): {}",
        options.out.display()
    ));
    let assessment = Verdict::on(format!("joints of the changed arm are simulated within {after:.2}°")).because(
        Criterion::ErrorOverBaseline,
        verdict::ratio(after, before),
        format!("joints are off by {after:.3}° adapted, {before:.3}° as the actuator was, on the recordings that it was adapted to"),
    );
    Ok(Outcome {
        before_deg: before,
        after_deg: after,
        actuator: options.out.clone(),
        verdict: verdict::repeated(assessment, trajectories.len(), "recording").verdict(),
        recording_warnings: findings.into_warnings(),
        held_joints: held_joints(&model),
    })
}

/// Mean absolute error of the joints in pure simulation [deg].
fn error(actuator: &NeuralActuator, model: &Model, trajectories: &[Trajectory]) -> Result<f64, BadInput> {
    let simulation = actuator.simulation(model)?;
    let telemetry = TelemetrySource::Modelled(&actuator.currents);
    let roll = |one: &Trajectory| roll_out(actuator, &simulation, one, telemetry).positions;
    let positions = parallel::map(trajectories, roll);
    Ok(pose_scores(&actuator.features, trajectories, &positions, usize::MAX - 1).mean_deg())
}
