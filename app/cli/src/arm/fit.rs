//! `hysteron arm fit`: the words of its verbs.

use hysteron_workflow::Context;
use hysteron_workflow::arm::fit::{delan, neural};
use hysteron_workflow::shared::outcome::Printed;

/// Learn a model from recordings
#[derive(Debug, clap::Args)]
pub struct Arguments {
    #[command(subcommand)]
    what: FitCommand,
}

#[derive(Debug, clap::Subcommand)]
enum FitCommand {
    #[command(after_help = include_str!("../help/arm-fit-delan.txt"))]
    Delan(delan::Options),
    #[command(after_help = include_str!("../help/arm-fit-neural.txt"))]
    Neural(Box<neural::Options>),
}

/// Runs the verb.
pub fn run(arguments: &Arguments, context: &Context) -> anyhow::Result<Printed> {
    match &arguments.what {
        FitCommand::Delan(options) => Printed::new(&delan::run(options, context)?),
        FitCommand::Neural(options) => Printed::new(&neural::run(options, context)?),
    }
}
