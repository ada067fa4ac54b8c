//! `hysteron arm export`: a robot as a file for other programs.

use std::path::PathBuf;

use hysteron_base::{BadInput, Table, file};

use hysteron_workflow::Caller;
use hysteron_workflow::outputs::SIGNATURE;

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
    let mut model = super::model(&arguments.model)?;
    if let Some(path) = &arguments.parameters {
        let table = Table::read(path, None)?;
        model = model.with_parameters(&table).map_err(|bad| bad.within(path.display()))?;
    }
    let outputs = super::reads(&arguments.model).and(arguments.parameters.as_deref());
    let _claim = outputs.file("--out", &arguments.out).check(caller)?;
    let extension = arguments.out.extension().and_then(|extension| extension.to_str());
    let text = match (extension, arguments.joints) {
        (Some("xml"), true) => model.to_mjcf_joints(),
        (Some("xml"), false) => model.to_mjcf(),
        (Some("urdf"), false) => model.to_urdf()?,
        (Some("csv"), false) => model.parameters_csv(),
        (_, joints) => {
            let expected = if joints { "a file .xml, with --joints" } else { "a file .urdf, .xml or .csv" };
            return Err(BadInput::new("--out", expected, arguments.out.display().to_string()).into());
        }
    };
    let head = match extension {
        Some("csv") => format!("# command: {}\n", caller.command),
        _ => format!("{SIGNATURE}\n"),
    };
    file::write_bytes(&arguments.out, head + &text)?;
    if extension == Some("urdf") && model.joints().iter().any(|joint| joint.drive.armature != 0.0) {
        tracing::warn!("URDF has no armature: it is left out (--out NAME.xml has it)");
    }
    say(format_args!("{} joints: {}", model.n_joints(), arguments.out.display()));
    Ok(())
}
