//! Robots as files: URDF, MJCF or a table of parameters, by the ending of the name.

use std::path::Path;

use hysteron_arm_dynamics::{Joint, Model};
use hysteron_base::{BadInput, file};

use crate::Context;
use crate::shared::outputs::SIGNATURE;

/// Part of a robot to write.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// All of it.
    Whole,
    /// The joints of an MJCF.
    Joints,
}

/// Refuses a name, given by `option`, that has no ending of a file which can hold the part.
///
/// # Errors
/// `BadInput` with the endings there are.
pub fn check(option: &str, path: &Path, part: Part) -> Result<(), BadInput> {
    let ending = path.extension().and_then(|ending| ending.to_str()).unwrap_or_default();
    let (endings, expected) = match part {
        Part::Whole => (&["urdf", "xml", "csv"][..], "a file .urdf, .xml or .csv"),
        Part::Joints => (&["xml"][..], "a file .xml, with --joints"),
    };
    match endings.contains(&ending) {
        true => Ok(()),
        false => Err(BadInput::new(option, expected, path.display().to_string())),
    }
}

/// Writes the robot to a file whose name has been checked.
///
/// # Errors
/// A robot that URDF cannot hold; a file that cannot be written.
pub fn write(model: &Model, path: &Path, part: Part, context: &Context) -> anyhow::Result<()> {
    let ending = path.extension().and_then(|ending| ending.to_str()).unwrap_or_default();
    let text = match (ending, part) {
        (_, Part::Joints) => model.to_mjcf_joints(),
        ("xml", _) => model.to_mjcf(),
        ("csv", _) => model.parameters_csv(),
        _ => model.to_urdf()?,
    };
    let head = match ending {
        "csv" => format!("# command: {}\n", context.command),
        _ => format!("{SIGNATURE}\n"),
    };
    file::write_bytes(path, head + &text)?;
    if ending == "urdf" && model.joints().iter().any(|joint| joint.drive.armature != 0.0) {
        tracing::warn!("URDF has no armature: it is omitted (a file .xml has it)");
    }
    let joints = model.joints();
    if ending == "urdf" && joints.iter().any(|joint| joint.drive.stiffness != 0.0) {
        tracing::warn!("URDF has no springs: they are omitted (a file .xml has them)");
    }
    let is_lost = |joint: &Joint| match (ending, joint.compensation()) {
        ("urdf", part) => part != Some(0.0),
        ("xml", part) => part.is_none(),
        _ => false,
    };
    if let Some(joint) = joints.iter().find(|joint| is_lost(joint)) {
        tracing::warn!(
            "the gravity compensation of the body on {} is omitted: it is not that of a whole body, or URDF",
            joint.name
        );
    }
    Ok(())
}
