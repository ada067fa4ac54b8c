//! Writes a robot, with other parameters where a table has them.

use hysteron_base::Table;

use super::{Options, Outcome};
use crate::arm::{self, robot::held_joints};
use crate::shared::robot_file::{self, Part};
use crate::{Context, WorkflowError};

/// Runs the verb.
///
/// # Errors
/// Bad input; files that cannot be written.
pub fn run(options: &Options, context: &Context) -> Result<Outcome, WorkflowError> {
    Ok(export(options, context)?)
}

fn export(options: &Options, context: &Context) -> anyhow::Result<Outcome> {
    let part = if options.joints { Part::Joints } else { Part::Whole };
    let mut model = options.robot_options.model_of_any_mass(&options.model, context)?;
    if let Some(path) = &options.parameters {
        let table = Table::read(path, None)?;
        model = model.with_parameters(&table).map_err(|bad| bad.within(path.display()))?;
    }
    let outputs = arm::reads(&options.model).and(options.parameters.as_deref());
    let _lock = outputs.file("--out", &options.out).check(context)?;
    robot_file::check("--out", &options.out, part)?;
    robot_file::write(&model, &options.out, part, context)?;
    context.print(format_args!("{} joints: {}", model.n_joints(), options.out.display()));
    Ok(Outcome { joints: model.n_joints(), out: options.out.clone(), held_joints: held_joints(&model) })
}
