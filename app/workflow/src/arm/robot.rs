//! Robots and drives that a person names: a file, or something built in.

use std::path::Path;

use hysteron_actuator::CatalogueDrive;
use hysteron_arm_dynamics::{Base, Masses, Model, ReadOptions};
use hysteron_base::{BadInput, file};

use crate::Context;
use crate::shared::outputs::Outputs;

/// How a robot file is read.
#[derive(Debug, Clone, Default)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct RobotOptions {
    /// Hold a robot that floats: its base and all free joints stay where the file puts them
    #[cfg_attr(feature = "clap", arg(long))]
    pub fix_base: bool,
    /// Value of an argument of a robot file that is xacro; can be given several times
    #[cfg_attr(feature = "clap", arg(long = "arg", value_name = "NAME=VALUE"))]
    pub arguments: Vec<String>,
}

impl RobotOptions {
    /// The built-in robot of that name, else the one in that file, with a mass matrix that is definite. What was ignored
    /// in the file, and the joints that are held, are logged.
    ///
    /// # Errors
    /// A robot that cannot be read.
    pub fn model(&self, text: &str, context: &Context) -> anyhow::Result<Model> {
        self.read(text, Masses::Definite, context)
    }

    /// The same with any mass matrix, for kinematics and inverse dynamics.
    ///
    /// # Errors
    /// A robot that cannot be read.
    pub fn model_of_any_mass(&self, text: &str, context: &Context) -> anyhow::Result<Model> {
        self.read(text, Masses::Any, context)
    }

    fn read(&self, text: &str, masses: Masses, context: &Context) -> anyhow::Result<Model> {
        if is_built_in(text) {
            if let Some(argument) = self.arguments.first() {
                let place = format!("--arg {argument}");
                return Err(BadInput::new(place, "a robot file that is xacro", "a built-in robot").into());
            }
            return Ok(Model::builtin(text)?);
        }
        let mut arguments = hysteron_arm_dynamics::Arguments::new();
        for argument in &self.arguments {
            let Some((name, value)) = argument.split_once('=').filter(|(name, _)| !name.is_empty()) else {
                return Err(BadInput::new("--arg", "NAME=VALUE", format!("\"{argument}\"")).into());
            };
            arguments.insert(name.to_owned(), value.to_owned());
        }
        let base = if self.fix_base { Base::Fixed } else { Base::AsInFile };
        let model = Model::read_with(Path::new(text), &ReadOptions { base, masses, arguments })?;
        for joint in &model.notes().welded {
            context.print(format_args!("joint \"{}\", which is {}, is held at zero", joint.name, joint.kind));
        }
        model.notes().warnings.iter().for_each(|warning| context.print(format_args!("warning: {warning}")));
        Ok(model)
    }
}

/// Refuses the file of a robot where a model that learned from recordings is expected; `option` takes the robot.
///
/// # Errors
/// `BadInput` that names the option of the robot.
pub fn refuse_robot(path: &Path, expected: &str, hint: &str) -> Result<(), BadInput> {
    let ending = path.extension().and_then(|ending| ending.to_str()).map(str::to_ascii_lowercase);
    match ending.as_deref() {
        Some("urdf" | "xml" | "mjcf" | "xacro") => {
            Err(BadInput::new(path.display().to_string(), expected, "the file of a robot").hint(hint))
        }
        _ => Ok(()),
    }
}

fn is_built_in(text: &str) -> bool {
    let is_path = text.contains(['.', '/']) || Path::new(text).exists();
    Model::builtin_names().any(|name| name == text) || !is_path
}

/// The drive of that name, else the one in that file.
pub fn drive(text: &str) -> anyhow::Result<CatalogueDrive> {
    let is_file = text.contains(['.', '/']);
    if !is_file || CatalogueDrive::names().any(|name| name == text) {
        return Ok(CatalogueDrive::named(text).map_err(|bad| BadInput { place: "--drive".into(), ..bad })?);
    }
    let read = file::read_text(Path::new(text))?;
    Ok(CatalogueDrive::parse(&read).map_err(|bad| bad.within(text))?)
}

/// The file that `text` is, if it is no name of something built in.
pub fn file_of(text: &str) -> Option<&str> {
    Some(text).filter(|text| Path::new(text).exists())
}

/// Input files of a robot: its file, if it is not built in.
pub fn reads(text: &str) -> Outputs {
    Outputs::reading(file_of(text))
}

/// The frame called `name`, or the last one.
pub(super) fn frame(model: &Model, name: Option<&str>) -> anyhow::Result<usize> {
    match name {
        Some(name) => Ok(model.frame(name)?),
        None => Ok(model.frames().len() - 1),
    }
}

/// Names of the joints that `--fix-base` holds at zero.
pub(super) fn held_joints(model: &Model) -> Vec<String> {
    model.notes().welded.iter().map(|joint| joint.name.clone()).collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test may stop where it stands

    use hysteron_base::json;

    use super::*;
    use crate::arm::export;

    #[test]
    fn an_outcome_names_the_joints_that_are_held_and_is_silent_where_none_is() {
        let folder = tempfile::tempdir().unwrap();
        let floating = folder.path().join("floats.xml");
        std::fs::write(
            &floating,
            "<mujoco><worldbody><body name=\"base\"><freejoint name=\"root\"/><geom size=\"0.1\" mass=\"1\"/>\
             <body name=\"link\"><joint name=\"hinge\" axis=\"0 1 0\"/><geom size=\"0.1\" mass=\"1\" pos=\"0 0 0.3\"/></body>\
             </body></worldbody></mujoco>",
        )
        .unwrap();
        let exported = |model: &str, fix_base: bool, out: &str| {
            let options = export::Options {
                model: model.to_owned(),
                robot_options: RobotOptions { fix_base, arguments: Vec::new() },
                out: folder.path().join(out),
                parameters: None,
                joints: false,
            };
            export::run(&options, &Context::silent("test")).unwrap()
        };
        let held = exported(floating.to_str().unwrap(), true, "held.csv");
        assert_eq!((held.joints, &held.held_joints[..]), (1, &["root".to_owned()][..]));
        let text = json::to_text(&held).unwrap();
        assert_eq!(json::from_text::<export::Outcome>(&text).unwrap().held_joints, held.held_joints);
        let free = exported("three-link", false, "three-link.csv");
        assert!(!json::to_text(&free).unwrap().contains("held_joints"));
    }
}
