//! Training data of an actuator: the features of the recordings, and their labels in words.

use hysteron_arm_estimation::ArmRecording;
use hysteron_arm_learning::neural::{FeatureLayout, Trajectory, gripper_of};
use hysteron_base::{BadInput, Recording};

use crate::Context;
use crate::arm::recordings::Named;

/// Features common to all recordings: motors, and a gripper as the last of them where its aperture is known.
pub(super) fn features_of(named: &[Named]) -> anyhow::Result<FeatureLayout> {
    let motors = |one: &Named| -> anyhow::Result<usize> {
        let within = |bad: BadInput| bad.within(one.path.display());
        Ok(ArmRecording::of(&one.recording).map_err(within)?.joints.len())
    };
    let all: Vec<&Recording> = named.iter().map(|one| &one.recording).collect();
    let m = motors(&named[0])?;
    let owned: Vec<Recording> = all.into_iter().cloned().collect();
    let gripper = gripper_of(&owned)?;
    if gripper.is_some() && m < 2 {
        return Err(
            BadInput::new("recordings", "joints other than the gripper's motor", "that motor alone").into()
        );
    }
    Ok(FeatureLayout { joints: m - usize::from(gripper.is_some()), gripper })
}

/// Names of the recordings with their lengths, which identify a training.
pub(super) fn names(named: &[Named]) -> Vec<String> {
    named.iter().map(|one| format!("{} ({} rows)", one.path.display(), one.recording.n_samples())).collect()
}

/// Prints a summary of the labels before training.
pub(super) fn print_data(
    training: &[Trajectory],
    validation: &[Trajectory],
    n_parameters: usize,
    context: &Context,
) {
    let rows: usize = training.iter().map(Trajectory::len).sum();
    let labelled = training.iter().flat_map(|one| &one.force).filter(|force| force.is_some()).count();
    let conditions = training.iter().filter(|one| one.is_healthy == Some(false)).count();
    context.print(format_args!(
        "{} trajectories with {rows} rows to learn from, {} to validate; {n_parameters} parameters",
        training.len(),
        validation.len()
    ));
    if labelled == 0 {
        context.print("no row has a labelled force: force and contact are not learned");
    }
    if conditions == 0 {
        context.print("no recording has a degraded motor: the condition is not learned");
    }
}
