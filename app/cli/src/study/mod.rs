//! `hysteron study run` and `hysteron demo`: a stage of a study is this program, started again with the arguments
//! that a person would type.

pub mod demo;
mod runner;

use hysteron_studies::chain::{self, Options, Outcome};
use hysteron_studies::{ArmStudy, TendonStudy};
use hysteron_workflow::Context;
use hysteron_workflow::shared::outcome::Printed;

use crate::invocation::Relaunch;
use runner::Runner;

/// Studies: published results, measured again; and the chain of stages of a study file
#[derive(Debug, clap::Args)]
pub struct Arguments {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Debug, clap::Subcommand)]
enum Verb {
    #[command(after_help = include_str!("../help/study.txt"))]
    Run(Options),
    #[command(flatten)]
    Tendon(TendonStudy),
    #[command(flatten)]
    Arm(ArmStudy),
}

/// Runs the verb; `relaunch` starts the stages of a study.
pub fn verb(arguments: &Arguments, relaunch: &Relaunch, context: &Context) -> anyhow::Result<Printed> {
    match &arguments.verb {
        Verb::Run(options) => Printed::new(&run(options, relaunch, context)?),
        Verb::Tendon(study) => study.run(context),
        Verb::Arm(study) => study.run(context),
    }
}

/// Runs the verb; `relaunch` starts the stages.
pub fn run(options: &Options, relaunch: &Relaunch, context: &Context) -> anyhow::Result<Outcome> {
    let run_stages = |out: &std::path::Path, study: &chain::Study, stages: &[chain::Stage]| {
        Runner::new(out, &study.name, (relaunch, context))?.run(stages)
    };
    Ok(chain::run(options, run_stages, context)?)
}
