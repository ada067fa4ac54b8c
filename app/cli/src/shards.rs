//! `hysteron shards`: the words of its verbs.

use hysteron_workflow::Context;
use hysteron_workflow::shared::outcome::Printed;
use hysteron_workflow::tendon::shards;

/// Synthetic data made by many machines, in a folder or an object store
///
/// `plan` describes the set, `work` makes shards of it on any number of machines, `status` shows how far they are,
/// and `merge` writes the card of the whole. docs/many-machines.md is the guide.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    #[command(subcommand)]
    verb: Verb,
}

/// Verbs of a set of shards.
#[derive(Debug, clap::Subcommand)]
enum Verb {
    #[command(after_help = include_str!("help/shards-plan.txt"))]
    Plan(shards::plan::Options),
    #[command(after_help = include_str!("help/shards-work.txt"))]
    Work(shards::work::Options),
    #[command(after_help = include_str!("help/shards-status.txt"))]
    Status(shards::status::Options),
    #[command(after_help = include_str!("help/shards-merge.txt"))]
    Merge(shards::merge::Options),
}

/// Runs the verb.
pub fn run(arguments: &Arguments, context: &Context) -> anyhow::Result<Printed> {
    match &arguments.verb {
        Verb::Plan(options) => Printed::new(&shards::plan::run(options, context)?),
        Verb::Work(options) => Printed::new(&shards::work::run(options, context)?),
        Verb::Status(options) => Printed::new(&shards::status::run(options, context)?),
        Verb::Merge(options) => Printed::new(&shards::merge::run(options, context)?),
    }
}
