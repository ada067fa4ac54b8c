//! Evaluates a neural actuator: rollouts by horizon next to simple baselines, forces, contact, condition.

use std::collections::BTreeMap;

use hysteron_arm_learning::neural::{
    BaselineComparison, ByHorizon, ByMethod, FORCES, HORIZONS, METHODS, NeuralActuator, Trajectory,
};
use hysteron_base::checks::Purpose;
use hysteron_base::{BadInput, file, json};
use hysteron_report::folder::ReportFolder;

use super::outcome::ActuatorEvaluation;
use super::{Options, page};
use crate::Context;
use crate::arm::recordings::{self, Role, checked, read, trajectories};
use crate::arm::{self, robot::held_joints};
use crate::shared::error::Cancelled;

/// Evaluates an actuator and its baselines on recordings.
///
/// # Errors
/// Bad input; files that cannot be written; an interruption.
pub(super) fn evaluate(options: &Options, context: &Context) -> anyhow::Result<ActuatorEvaluation> {
    let actuator = NeuralActuator::read(&options.model)?;
    let files = recordings::files(&options.recordings, &options.leave_out)?;
    let known = match &options.detectors[..] {
        [] => Vec::new(),
        named => recordings::files(named, &options.leave_out)?,
    };
    let outputs = arm::reads(&options.robot).and(&files).and(&known);
    let outputs = options.out.iter().fold(outputs, |all, out| all.file("--out", out));
    let _lock = outputs.report("--figures", options.figures.as_deref()).check(context)?;
    let model = options.robot_options.model(&options.robot, context)?;
    context.listen();
    let mut by_task: BTreeMap<String, Vec<Trajectory>> = BTreeMap::new();
    let named = read(&files)?;
    let findings = checked(&named, &model, Purpose::Score)?;
    for one in named {
        // What a data set calls training or validation is no test.
        if one.role == Role::Test || !one.is_split {
            let settings = (&actuator.features, actuator.simulation.period, &options.free[..]);
            let found = trajectories(std::slice::from_ref(&one), one.role, settings)?;
            by_task.entry(one.task).or_default().extend(found);
        }
    }
    if by_task.is_empty() {
        let bad = BadInput::new(
            "recordings",
            "at least one for a test",
            "only recordings in folders train and validation",
        );
        return Err(bad.hint("name files, or a folder called test").into());
    }
    let bar = context.progress("tasks", by_task.len(), 0);
    let mut comparison = BaselineComparison::new(&actuator, &model)?;
    for (name, trajectories) in by_task {
        if context.is_cancelled() {
            return Err(Cancelled::new("; nothing is written").into());
        }
        comparison.add(name, trajectories)?;
        bar.inc(1);
    }
    bar.finish();
    let mut detectors = None;
    if !known.is_empty() {
        let known = read(&known)?;
        let settings = (&actuator.features, actuator.simulation.period, &options.free[..]);
        let training = trajectories(&known, Role::Training, settings)?;
        detectors = Some(comparison.detectors("", &training)?);
    }
    let warnings = (findings.into_warnings(), held_joints(&model));
    let outcome = ActuatorEvaluation::new(comparison.summary(), detectors, warnings, context);
    print(&outcome, context);
    if let Some(out) = &options.out {
        file::write_bytes(out, json::to_text(&outcome)?)?;
    }
    if let Some(folder) = &options.figures {
        page::write(&ReportFolder { path: folder, png: false }, &outcome)?;
        context.reported(folder);
    }
    Ok(outcome)
}

/// Errors by method and horizon.
fn print_poses(errors: &ByMethod<ByHorizon<Option<f64>>>, (what, unit): (&str, &str), context: &Context) {
    context.print(format_args!(
        "mean absolute error {what} over the first steps of rollouts [{unit}], mean of tasks:"
    ));
    let head = HORIZONS.map(|h| format!("{h:>8}")).concat();
    context.print(format_args!("{:56}{head}", ""));
    for (name, errors) in METHODS.iter().zip(errors.values()) {
        let cells = errors.values().map(|error| format!("{:>8}", page::number(*error)));
        context.print(format_args!("{name:56}{}", cells.concat()));
    }
}

fn print(found: &ActuatorEvaluation, context: &Context) {
    print_poses(&found.mean_deg, ("of the joints", "deg"), context);
    if found.mean_gripper_mm.network.steps_100.is_some() {
        print_poses(&found.mean_gripper_mm, ("of the aperture", "mm"), context);
    }
    for ((_, name), force) in FORCES.iter().zip(found.forces.values()) {
        let Some(force) = force else { continue };
        let [all, loaded, axis, norm, wrong, missed] = page::force_cells(force);
        context.print(format_args!(
            "force, {name}: mean of three axes {all} N (under force {loaded} N), loaded axis {axis} N, norm {norm} N; false contact {wrong}, missed {missed}"
        ));
    }
    if let Some([accuracy, auc]) = found.condition_accuracy_auc {
        context.print(format_args!("condition: accuracy {accuracy:.3}, area under the curve {auc:.3}"));
    }
    for detector in found.detectors.iter().flatten() {
        context.print(format_args!(
            "condition over windows, {}: accuracy {}, area {}",
            detector.name,
            page::number(Some(detector.accuracy)),
            page::number(Some(detector.area))
        ));
    }
}
