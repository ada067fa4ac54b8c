//! Simulates an arm under recorded torques.

use hysteron_arm_dynamics::Model;
use hysteron_arm_estimation::{JointQuantityKind, joint_rows, motion_under_torques};
use hysteron_base::{BadInput, Recording};
use hysteron_report::folder::ReportFolder;

use super::{Options, Outcome, page};
use crate::shared::memory;
use crate::{Context, WorkflowError, arm};

/// Runs the verb.
///
/// # Errors
/// Bad input; files that cannot be written.
pub fn run(options: &Options, context: &Context) -> Result<Outcome, WorkflowError> {
    Ok(simulate(options, context)?)
}

fn simulate(options: &Options, context: &Context) -> anyhow::Result<Outcome> {
    let model = options.robot_options.model(&options.model, context)?;
    let torques = memory::recording(&options.torques)?;
    // Time, coordinates, speeds, accelerations and torques.
    memory::check_result(&options.torques, torques.n_samples(), 1 + 4 * model.n_joints())?;
    let outputs = arm::reads(&options.model).and([&options.torques]).recording("--out", &options.out);
    let _lock = outputs.report("--figures", options.figures.as_deref()).check(context)?;
    let start = match options.start.is_empty() {
        true => first_row(&model, &torques).map_err(|bad| bad.within(options.torques.display()))?,
        false => options.start.clone(),
    };
    let motion = motion_under_torques(
        &model,
        &torques,
        &start,
        usize::from(options.substeps),
        arm::meta(context, "rigid-body simulation"),
    )
    .map_err(|bad| bad.within(options.torques.display()))?;
    motion.write(&options.out)?;
    let outcome = Outcome::new(&model, &motion)?;
    if let Some(folder) = &options.figures {
        let folder = ReportFolder { path: folder, png: options.png };
        page::write(&folder, &model, &motion, &outcome)?;
    }
    context.print(format_args!("{} rows: {}", motion.n_samples(), options.out.display()));
    Ok(outcome)
}

/// Coordinates of the first row; zero where there are none.
fn first_row(model: &Model, recording: &Recording) -> Result<Vec<f64>, BadInput> {
    let n = model.n_joints();
    let rows = joint_rows(model, recording, JointQuantityKind::Position)?;
    Ok(rows.map_or_else(|| vec![0.0; n], |rows| rows[..n].to_vec()))
}
