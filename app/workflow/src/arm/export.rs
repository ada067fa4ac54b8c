//! `hysteron arm export`: a robot as a file for other programs.

use std::path::PathBuf;

use hysteron_base::Table;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::Context;
use crate::shared::robot_file::{self, Part};

/// Write a robot as URDF, MJCF or a table of parameters
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    /// File of URDF or MJCF, or name of a built-in robot
    pub model: String,
    /// How the robot is read
    #[cfg_attr(feature = "clap", command(flatten))]
    pub robot_options: super::RobotOptions,
    /// Where it goes: .urdf, .xml or .csv
    #[cfg_attr(feature = "clap", arg(long, value_name = "FILE"))]
    pub out: PathBuf,
    /// Table with a row for each joint, whose parameters replace those of the robot
    #[cfg_attr(feature = "clap", arg(long, value_name = "CSV"))]
    pub parameters: Option<PathBuf>,
    /// The joints of an MJCF alone
    #[cfg_attr(feature = "clap", arg(long))]
    pub joints: bool,
}

/// The outcome of `arm export`.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Outcome {
    /// Number of joints that move.
    pub joints: usize,
    /// The file.
    pub out: PathBuf,
}

impl crate::shared::outcome::Outcome for Outcome {}

/// Carries out the verb.
///
/// # Errors
/// Bad input; files that cannot be written.
pub fn run(options: &Options, context: &Context) -> anyhow::Result<Outcome> {
    let part = if options.joints { Part::Joints } else { Part::Whole };
    let mut model = options.robot_options.model_of_any_mass(&options.model, context)?;
    if let Some(path) = &options.parameters {
        let table = Table::read(path, None)?;
        model = model.with_parameters(&table).map_err(|bad| bad.within(path.display()))?;
    }
    let outputs = super::reads(&options.model).and(options.parameters.as_deref());
    let _claim = outputs.file("--out", &options.out).check(context)?;
    robot_file::check("--out", &options.out, part)?;
    robot_file::write(&model, &options.out, part, context)?;
    context.print(format_args!("{} joints: {}", model.n_joints(), options.out.display()));
    Ok(Outcome { joints: model.n_joints(), out: options.out.clone() })
}
