//! `hysteron arm`: rigid-body arms.

mod fit;
mod identify;

use hysteron_base::BadInput;
use hysteron_studies::ArmStudy;
use hysteron_workflow::shared::outcome::Printed;
use hysteron_workflow::{Context, arm};

const HELP: &str = "\
MODEL is a file of URDF, xacro or MJCF (docs/robot-files.md), or the name of a built-in robot: open-manipulator-x, panda, so101, scara, three-link, wrist.

Examples, from the root of the repository:
  hysteron arm info panda
  hysteron arm check arm/dynamics/robots/so101.urdf
  hysteron arm info arm/dynamics/tests/data/robot_files/floating_base.urdf --fix-base

`hysteron arm VERB --help` shows what each reads and writes.

Exit codes: 0 done, 1 failed, 2 bad input (nothing is written under the final name).";

/// Rigid-body arms: robot files, dynamics, identification, learning
#[derive(Debug, clap::Args)]
#[command(after_help = HELP)]
pub struct Arguments {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Debug, clap::Subcommand)]
enum Verb {
    #[command(after_help = include_str!("../help/arm-adapt.txt"))]
    Adapt(arm::adapt::Options),
    Info(arm::info::Options),
    Check(arm::info::CheckOptions),
    #[command(after_help = include_str!("../help/arm-dynamics.txt"))]
    Dynamics(arm::dynamics::Options),
    #[cfg(unix)]
    #[command(after_help = include_str!("../help/arm-emulate.txt"))]
    Emulate(arm::emulate::Options),
    #[command(after_help = include_str!("../help/arm-estimate.txt"))]
    Estimate(arm::estimate::Options),
    #[command(after_help = include_str!("../help/arm-evaluate.txt"))]
    Evaluate(arm::evaluate::Options),
    #[command(after_help = include_str!("../help/arm-excite.txt"))]
    Excite(arm::excite::Options),
    #[command(after_help = include_str!("../help/arm-export.txt"))]
    Export(arm::export::Options),
    Fit(fit::Arguments),
    #[command(after_help = include_str!("../help/arm-generate.txt"))]
    Generate(arm::generate::Options),
    Identify(identify::Arguments),
    /// Moved to `hysteron import`
    #[command(hide = true)]
    Import {
        /// Arguments of `hysteron import`
        #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
        arguments: Vec<String>,
    },
    #[command(after_help = include_str!("../help/arm-record.txt"))]
    Record(arm::record::Options),
    #[command(after_help = include_str!("../help/arm-simulate.txt"))]
    Simulate(arm::simulate::Options),
    /// As `hysteron study`
    #[command(subcommand, hide = true)]
    Study(ArmStudy),
}

/// Runs the verb.
pub fn run(arguments: &Arguments, context: &Context) -> anyhow::Result<Printed> {
    match &arguments.verb {
        Verb::Adapt(options) => Printed::new(&arm::adapt::run(options, context)?),
        Verb::Info(options) => Printed::new(&arm::info::run(options, context)?),
        Verb::Check(options) => Printed::new(&arm::info::check(options, context)?),
        Verb::Dynamics(options) => Printed::new(&arm::dynamics::run(options, context)?),
        #[cfg(unix)]
        Verb::Emulate(options) => Printed::new(&arm::emulate::run(options, context)?),
        Verb::Estimate(options) => Printed::new(&arm::estimate::run(options, context)?),
        Verb::Evaluate(options) => Printed::new(&arm::evaluate::run(options, context)?),
        Verb::Excite(options) => Printed::new(&arm::excite::run(options, context)?),
        Verb::Export(options) => Printed::new(&arm::export::run(options, context)?),
        Verb::Fit(arguments) => fit::run(arguments, context),
        Verb::Generate(options) => Printed::new(&arm::generate::run(options, context)?),
        Verb::Identify(arguments) => identify::run(arguments, context),
        Verb::Import { arguments } => Err(moved(arguments).into()),
        Verb::Record(options) => Printed::new(&arm::record::run(options, context)?),
        Verb::Simulate(options) => Printed::new(&arm::simulate::run(options, context)?),
        Verb::Study(study) => study.run(context),
    }
}

/// The error of `arm import`, which is `hysteron import` now.
fn moved(arguments: &[String]) -> BadInput {
    let command = format!("hysteron import {}", arguments.join(" ").replace("--columns", "--map"));
    BadInput::new("arm import", "hysteron import, for arms and tendon robots", "the old name")
        .hint(command.trim_end())
}
