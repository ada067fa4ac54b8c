//! `hysteron run` and `hysteron demo`: a stage of a study is this program, started again with the arguments that a person
//! would type.

pub mod demo;
mod runner;

use hysteron_workflow::Caller;
use hysteron_workflow::study::{self, Options};
use serde_json::Value;

use runner::Runner;

/// Carries out the verb; `passed_on` are options of all verbs.
pub fn run(options: &Options, passed_on: &[String], caller: &Caller) -> anyhow::Result<Value> {
    study::run(options, |out, study, stages| Runner::new(out, &study.name, passed_on)?.run(stages), caller)
}
