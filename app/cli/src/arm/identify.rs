//! `hysteron arm identify`: the words of its verbs.

use hysteron_workflow::Context;
use hysteron_workflow::arm::identify::{friction, inertia, payload, servo};
use hysteron_workflow::shared::outcome::Printed;

/// Identify an arm from recordings of it
#[derive(Debug, clap::Args)]
pub struct Arguments {
    #[command(subcommand)]
    what: IdentifyCommand,
}

#[derive(Debug, clap::Subcommand)]
enum IdentifyCommand {
    #[command(after_help = include_str!("../help/arm-identify-inertia.txt"))]
    Inertia(inertia::Options),
    #[command(after_help = include_str!("../help/arm-identify-friction.txt"))]
    Friction(friction::Options),
    #[command(after_help = include_str!("../help/arm-identify-servo.txt"))]
    Servo(servo::Options),
    #[command(after_help = include_str!("../help/arm-identify-payload.txt"))]
    Payload(payload::Options),
}

/// Runs the verb.
pub fn run(arguments: &Arguments, context: &Context) -> anyhow::Result<Printed> {
    match &arguments.what {
        IdentifyCommand::Inertia(options) => Printed::new(&inertia::run(options, context)?),
        IdentifyCommand::Friction(options) => Printed::new(&friction::run(options, context)?),
        IdentifyCommand::Servo(options) => Printed::new(&servo::run(options, context)?),
        IdentifyCommand::Payload(options) => Printed::new(&payload::run(options, context)?),
    }
}
