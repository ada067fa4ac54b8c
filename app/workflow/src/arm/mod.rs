//! `hysteron arm`: rigid-body arms.

pub mod dynamics;
#[cfg(unix)]
pub mod emulate;
pub mod excite;
pub mod export;
pub mod fit;
pub mod generate;
pub mod identify;
pub mod info;
pub(crate) mod learned_dynamics;
pub mod record;
pub mod simulate;

use std::path::Path;

use hysteron_actuator::CatalogueDrive;
use hysteron_arm::{Base, Masses, Model, ReadOptions};
use hysteron_base::{BadInput, Metadata, file};

use crate::shared::outputs::Outputs;
use crate::{COMMIT, Context};

/// How a robot file is read.
#[derive(Debug, Clone, Default)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct RobotOptions {
    /// Hold a robot that floats: its base, and whatever else moves freely, stays where its file puts it
    #[cfg_attr(feature = "clap", arg(long))]
    pub fix_base: bool,
    /// Value of an argument of a robot file that is xacro; can be given several times
    #[cfg_attr(feature = "clap", arg(long = "arg", value_name = "NAME=VALUE"))]
    pub arguments: Vec<String>,
}

impl RobotOptions {
    /// The built-in robot of that name, else the one in that file, with a mass matrix that is definite. What was ignored
    /// in the file, and what was held, is said.
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
        let mut arguments = hysteron_arm::Arguments::new();
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
/// `BadInput` that says where the robot goes.
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

/// Who makes a recording, and what it is.
pub fn meta(context: &Context, source: &str) -> Metadata {
    Metadata {
        source: source.to_owned(),
        commit: COMMIT.to_owned(),
        command: context.command.clone(),
        ..Metadata::default()
    }
}

/// The frame called `name`, or the last one.
fn frame(model: &Model, name: Option<&str>) -> anyhow::Result<usize> {
    match name {
        Some(name) => Ok(model.frame(name)?),
        None => Ok(model.frames().len() - 1),
    }
}
