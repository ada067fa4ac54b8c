//! `hysteron arm`: rigid-body arms.

mod dynamics;
mod estimation_study;
mod excite;
mod export;
mod fit;
mod identify;
mod import;
mod info;
mod simulate;
mod study;

use std::path::Path;

use hysteron_arm::Model;
use hysteron_base::Metadata;

use crate::terminal;
use hysteron_workflow::outputs::Outputs;
use hysteron_workflow::{COMMIT, Caller};
use serde_json::Value;

const HELP: &str = "\
MODEL is a file of URDF or MJCF, or the name of a built-in robot: open-manipulator-x, panda, so101, scara, three-link, wrist.

Examples, from the root of the repository:
  hysteron arm info panda
  hysteron arm check arm/robots/so101.urdf

`hysteron arm VERB --help` shows what each reads and writes.

Exit codes: 0 done, 1 failed, 2 bad input (nothing is written under the final name).";

/// Rigid-body arms: what a robot file holds, its dynamics, its motion
#[derive(Debug, clap::Args)]
#[command(after_help = HELP)]
pub struct Arguments {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Debug, clap::Subcommand)]
enum Verb {
    Info(info::Arguments),
    Check(info::CheckArguments),
    Dynamics(dynamics::Arguments),
    Evaluate(fit::EvaluateArguments),
    Excite(excite::Arguments),
    Export(export::Arguments),
    Fit(fit::Arguments),
    Identify(identify::Arguments),
    Import(import::Arguments),
    Simulate(simulate::Arguments),
    Study(study::Arguments),
}

/// Carries out the verb.
pub fn run(arguments: &Arguments, caller: &Caller) -> anyhow::Result<Value> {
    match &arguments.verb {
        Verb::Info(arguments) => info::run(arguments).map(|()| Value::Null),
        Verb::Check(arguments) => info::check(arguments).map(|()| Value::Null),
        Verb::Dynamics(arguments) => dynamics::run(arguments, caller).map(|()| Value::Null),
        Verb::Evaluate(arguments) => fit::evaluate(arguments, caller),
        Verb::Excite(arguments) => excite::run(arguments, caller),
        Verb::Export(arguments) => export::run(arguments, caller).map(|()| Value::Null),
        Verb::Fit(arguments) => fit::run(arguments, caller),
        Verb::Identify(arguments) => identify::run(arguments, caller),
        Verb::Import(arguments) => import::run(arguments, caller).map(|()| Value::Null),
        Verb::Simulate(arguments) => simulate::run(arguments, caller).map(|()| Value::Null),
        Verb::Study(arguments) => study::run(arguments, caller),
    }
}

/// The built-in robot of that name, else the one in that file.
fn model(text: &str) -> anyhow::Result<Model> {
    if Model::builtin_names().any(|name| name == text) {
        return Ok(Model::builtin(text)?);
    }
    if !text.contains(['.', '/']) && !Path::new(text).exists() {
        return Ok(Model::builtin(text)?);
    }
    Ok(Model::read(Path::new(text))?)
}

/// What a verb reads of a robot: its file, if it is not built in.
fn reads(text: &str) -> Outputs {
    Outputs::reading(Some(text).filter(|text| Path::new(text).exists()))
}

/// Who makes a recording, and what it is.
fn meta(source: &str) -> Metadata {
    Metadata {
        source: source.to_owned(),
        commit: COMMIT.to_owned(),
        command: terminal::command_line(),
        ..Metadata::default()
    }
}

/// The frame called `name`, or the last one.
fn frame(model: &Model, name: Option<&str>) -> anyhow::Result<usize> {
    match name {
        Some(name) => Ok(model.frame(name)?),
        None => Ok(model.frames().len() - 1),
    }
}
