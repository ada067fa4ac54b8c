//! The program `hysteron`: arguments, progress and errors; what verbs do is in `hysteron-workflow`.
//!
//! Every failure comes back here as one error, which decides the exit code: 2 for a user error, 1 for
//! everything else.

mod arguments;
mod arm;
mod caller;
mod failure;
mod interrupt;
mod limits;
mod manual;
mod progress;
mod rig;
mod study;
mod terminal;

use std::process::ExitCode;

use clap::CommandFactory;
use hysteron_workflow::{self as workflow, Caller, watchdog};
use serde_json::Value;

use arguments::{Program, Verb};

fn main() -> ExitCode {
    let program = match Program::typed() {
        Ok(program) => program,
        Err(code) => return code,
    };
    terminal::start_log(program.verbosity());
    if program.is_json() {
        terminal::use_json();
    }
    let caller = caller::by_terminal(program.may_overwrite());
    match prepare(&program).and_then(|()| carry_out(&program, &caller)) {
        Ok(summary) => {
            terminal::conclude(&summary);
            terminal::exit_code_of_printing()
        }
        Err(error) => {
            if let Some(refused) = error.downcast_ref::<workflow::check::Refused>() {
                terminal::conclude(&refused.outcome);
            }
            if failure::is_told(&error) {
                tracing::warn!("{error:#}");
            } else {
                terminal::complain(&error);
            }
            ExitCode::from(failure::exit_code(&error))
        }
    }
}

/// Before any verb.
fn prepare(program: &Program) -> anyhow::Result<()> {
    limits::outlive_file_sizes()?;
    limits::check_address_space()?;
    // The watchdog ends with the program that it watches, and not before.
    if !matches!(program.verb, Verb::Watchdog { .. }) {
        interrupt::start()?;
    }
    program.use_threads()
}

/// Carries out the verb; what it came to is the value that `--json` prints.
fn carry_out(program: &Program, caller: &Caller) -> anyhow::Result<Value> {
    let nothing = |()| Value::Object(serde_json::Map::new());
    match &program.verb {
        Verb::Simulate(options) => workflow::simulate::run(options, caller),
        Verb::Reach(options) => workflow::reach::run(options, caller),
        Verb::Mesh(options) => workflow::mesh::run(options, caller),
        Verb::Check(options) => workflow::check::run(options, caller),
        Verb::Record(options) => workflow::record::run(options, caller),
        Verb::Import(options) => workflow::import::run(options, caller),
        Verb::FitMaterial(options) => workflow::fit_material::run(options, caller),
        Verb::Identify(options) => workflow::identify::run(options, caller),
        Verb::FitResidual(options) => workflow::fit_residual::run(options, caller),
        Verb::Adapt(options) => workflow::adapt::run(options, caller),
        Verb::Generate(options) => workflow::generate::run(options, caller),
        Verb::Target(options) => workflow::target::run(options, caller),
        Verb::Evaluate(options) => workflow::evaluate::run(options, caller),
        Verb::Train(options) => workflow::train::run(options, caller),
        Verb::Command(options) => workflow::command::run(options, caller),
        Verb::Track(options) => workflow::track::run(options, caller),
        Verb::FitSensor(options) => workflow::sense::fit::run(options, caller),
        Verb::Sense(options) => workflow::sense::run(options, caller),
        Verb::IdentifyServo(options) => workflow::identify_servo::run(options, caller),
        Verb::Study(arguments) => study::verb(arguments, &program.passed_on(), caller),
        Verb::Run(options) => study::run(options, &program.passed_on(), caller),
        Verb::Demo(arguments) => study::demo::run(arguments, &program.passed_on(), caller),
        Verb::Rig(arguments) => rig::run(arguments, caller),
        Verb::Arm(arguments) => arm::run(arguments, caller),
        Verb::Completions(arguments) => {
            manual::completions(arguments, Program::command());
            Ok(nothing(()))
        }
        Verb::Man(arguments) => manual::man(arguments, Program::command(), caller),
        Verb::Watchdog { rig } => watchdog::watch(rig).map(nothing),
    }
}
