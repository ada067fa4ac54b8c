//! Every quantity of rigid-body dynamics, or the torques of a learned model, for every row of states.

use std::path::Path;

use hysteron_arm_dynamics::{JointKind, Model};
use hysteron_arm_estimation::{DynamicsOutput, JointQuantityKind, columns_of_dynamics, dynamics_of_rows};
use hysteron_arm_learning::lagrangian::LearnedDynamics;
use hysteron_base::{BadInput, MAX_CHANNELS, Recording};

use super::{Options, Outcome};
use crate::arm;
use crate::arm::robot::{frame, held_joints};
use crate::shared::memory;
use crate::shared::outputs::Outputs;
use crate::{Context, WorkflowError};

/// Runs the verb.
///
/// # Errors
/// Bad input; files that cannot be written.
pub fn run(options: &Options, context: &Context) -> Result<Outcome, WorkflowError> {
    Ok(compute(options, context)?)
}

fn compute(options: &Options, context: &Context) -> anyhow::Result<Outcome> {
    if LearnedDynamics::is_file(options.model.as_ref()) {
        return learned(options, context);
    }
    let states = memory::recording(&options.states)?;
    // Torques follow from accelerations for any masses; the inverse needs a definite M.
    let is_inverse = [
        JointQuantityKind::Torque.channel(JointKind::Revolute, 0),
        JointQuantityKind::Torque.channel(JointKind::Prismatic, 0),
    ]
    .iter()
    .all(|name| states.channel(name).is_none());
    let model = match is_inverse {
        true => options.robot_options.model_of_any_mass(&options.model, context)?,
        false => options.robot_options.model(&options.model, context)?,
    };
    let frame = frame(&model, options.frame.as_deref())?;
    check_columns(&model, options, is_inverse)?;
    let n_columns = columns_of_dynamics(model.n_joints(), options.derivatives, is_inverse);
    memory::check_result(&options.states, states.n_samples(), n_columns)?;
    let output = DynamicsOutput { frame, derivatives: options.derivatives };
    let outputs = arm::reads(&options.model).and([&options.states]).recording("--out", &options.out);
    let _lock = outputs.check(context)?;
    let results = dynamics_of_rows(&model, &states, output, arm::meta(context, "rigid-body dynamics"))
        .map_err(|bad| bad.within(options.states.display()))?;
    written(&results, held_joints(&model), (options, context))
}

/// Refuses robots whose derivatives do not fit in a recording, with the number of joints that do.
fn check_columns(model: &Model, options: &Options, is_inverse: bool) -> Result<(), BadInput> {
    let of = |n: usize| columns_of_dynamics(n, options.derivatives, is_inverse);
    if of(model.n_joints()) <= MAX_CHANNELS {
        return Ok(());
    }
    let most = (1..=model.n_joints()).take_while(|n| of(*n) <= MAX_CHANNELS).count();
    let option = if options.derivatives { "--derivatives" } else { "MODEL" };
    let expected =
        format!("a robot of at most {most} joints: a recording has at most {MAX_CHANNELS} columns");
    let found = format!("{} joints, whose dynamics have {} columns", model.n_joints(), of(model.n_joints()));
    let hint = match options.derivatives {
        true => "without --derivatives it has fewer; joints that are fixed in the file do not count",
        false => "joints that are fixed in the file do not count",
    };
    Err(BadInput::new(option, expected, found).hint(hint))
}

/// Torques of a learned model for the same states.
fn learned(options: &Options, context: &Context) -> anyhow::Result<Outcome> {
    if options.derivatives || options.frame.is_some() {
        let option = if options.derivatives { "--derivatives" } else { "--frame" };
        let bad = BadInput::new(option, "a robot file", "a learned model, which has torques alone");
        return Err(bad.into());
    }
    let outputs =
        Outputs::reading([Path::new(&options.model), &options.states]).recording("--out", &options.out);
    let _lock = outputs.check(context)?;
    let states = memory::recording(&options.states)?;
    let meta = arm::meta(context, "learned inverse dynamics");
    let model = LearnedDynamics::read(options.model.as_ref())?;
    let found = model.torques_along(&states, meta).map_err(|bad| bad.within(options.states.display()))?;
    written(&found, Vec::new(), (options, context))
}

fn written(
    results: &Recording,
    held_joints: Vec<String>,
    (options, context): (&Options, &Context),
) -> anyhow::Result<Outcome> {
    results.write(&options.out)?;
    context.print(format_args!("{} rows: {}", results.n_samples(), options.out.display()));
    Ok(Outcome { rows: results.n_samples(), out: options.out.clone(), held_joints })
}
