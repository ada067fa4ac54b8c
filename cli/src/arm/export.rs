//! `hysteron arm export`: a robot as a file for other programs.

use std::path::PathBuf;

use hysteron_base::Table;
use hysteron_workflow::Caller;
use hysteron_workflow::robot_file::{self, Part};

use crate::terminal::say;

const HELP: &str = "\
The ending of --out decides: .urdf is a URDF, .xml an MJCF without shapes, .csv a table with a row for each joint (mass, centre of \
mass, second moment about it, armature, damping, dry friction; in the joint's frame). With --joints an .xml holds the joints alone, for \
an MJCF that has the bodies: armature, damping, frictionloss, range. URDF has no armature and no gravity.

--parameters replaces parameters by those of such a table, an identified one for example; columns that are not there keep what they \
were.

Examples:
  hysteron arm export panda --out panda.xml
  hysteron arm export panda --parameters identified.csv --out identified.urdf

Exit codes: 0 done, 1 failed, 2 bad input (nothing is written).";

/// Write a robot as URDF, MJCF or a table of parameters
#[derive(Debug, clap::Args)]
#[command(after_help = HELP)]
pub struct Arguments {
    /// File of URDF or MJCF, or name of a built-in robot
    model: String,
    /// Where it goes: .urdf, .xml or .csv
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// Table with a row for each joint, whose parameters replace those of the robot
    #[arg(long, value_name = "CSV")]
    parameters: Option<PathBuf>,
    /// The joints of an MJCF alone
    #[arg(long)]
    joints: bool,
}

/// Carries out the verb.
pub fn run(arguments: &Arguments, caller: &Caller) -> anyhow::Result<()> {
    let part = if arguments.joints { Part::Joints } else { Part::Whole };
    let mut model = super::model(&arguments.model)?;
    if let Some(path) = &arguments.parameters {
        let table = Table::read(path, None)?;
        model = model.with_parameters(&table).map_err(|bad| bad.within(path.display()))?;
    }
    let outputs = super::reads(&arguments.model).and(arguments.parameters.as_deref());
    let _claim = outputs.file("--out", &arguments.out).check(caller)?;
    robot_file::check("--out", &arguments.out, part)?;
    robot_file::write(&model, &arguments.out, part, caller)?;
    say(format_args!("{} joints: {}", model.n_joints(), arguments.out.display()));
    Ok(())
}
