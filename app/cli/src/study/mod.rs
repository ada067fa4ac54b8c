//! `hysteron study run` and `hysteron demo`: a stage of a study is this program, started again with the arguments
//! that a person would type.

pub mod demo;
mod runner;

use hysteron_workflow::Context;
use hysteron_workflow::study::{self, Options};
use serde_json::Value;

use runner::Runner;

/// Studies: several stages in order, each done once, into one report
#[derive(Debug, clap::Args)]
pub struct Arguments {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Debug, clap::Subcommand)]
enum Verb {
    #[command(after_help = include_str!("../help/study.txt"))]
    Run(Options),
}

/// Runs the verb; `passed_on` are options of all verbs.
pub fn verb(arguments: &Arguments, passed_on: &[String], context: &Context) -> anyhow::Result<Value> {
    let Verb::Run(options) = &arguments.verb;
    run(options, passed_on, context)
}

/// Runs the verb; `passed_on` are options of all verbs.
pub fn run(options: &Options, passed_on: &[String], context: &Context) -> anyhow::Result<Value> {
    study::run(options, |out, study, stages| Runner::new(out, &study.name, passed_on)?.run(stages), context)
}
