//! `hysteron arm identify`: the words of its verbs.

use hysteron_workflow::Context;
use hysteron_workflow::arm::identify::{friction, inertia, payload, servo};
use serde_json::Value;

/// Identify an arm from recordings of it
#[derive(Debug, clap::Args)]
pub struct Arguments {
    #[command(subcommand)]
    what: What,
}

#[derive(Debug, clap::Subcommand)]
enum What {
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
pub fn run(arguments: &Arguments, context: &Context) -> anyhow::Result<Value> {
    match &arguments.what {
        What::Inertia(options) => inertia::run(options, context),
        What::Friction(options) => friction::run(options, context),
        What::Servo(options) => servo::run(options, context),
        What::Payload(options) => payload::run(options, context),
    }
}
