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
use hysteron_workflow::outcome::Printed;
use hysteron_workflow::{self as workflow, Caller, watchdog};

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
    match prepare(&program).and_then(|()| run(&program, &caller)) {
        Ok(outcome) => {
            terminal::print_outcome(&outcome);
            terminal::exit_code_of_printing()
        }
        Err(error) => {
            if let Some(refused) = error.downcast_ref::<workflow::check::Refused>() {
                terminal::print_outcome(&refused.outcome);
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

/// Runs the verb.
fn run(program: &Program, caller: &Caller) -> anyhow::Result<Printed> {
    match &program.verb {
        Verb::Simulate(options) => Printed::new(&workflow::simulate::run(options, caller)?),
        Verb::Reach(options) => Printed::new(&workflow::reach::run(options, caller)?),
        Verb::Mesh(options) => Printed::new(&workflow::mesh::run(options, caller)?),
        Verb::Check(options) => Printed::new(&workflow::check::run(options, caller)?),
        Verb::Record(options) => Printed::new(&workflow::record::run(options, caller)?),
        Verb::Import(options) => Printed::new(&workflow::import::run(options, caller)?),
        Verb::FitMaterial(options) => Printed::untyped(&workflow::fit_material::run(options, caller)?),
        Verb::Identify(options) => Printed::untyped(&workflow::identify::run(options, caller)?),
        Verb::FitResidual(options) => Printed::untyped(&workflow::fit_residual::run(options, caller)?),
        Verb::Adapt(options) => Printed::untyped(&workflow::adapt::run(options, caller)?),
        Verb::Generate(options) => Printed::new(&workflow::generate::run(options, caller)?),
        Verb::Target(options) => Printed::new(&workflow::target::run(options, caller)?),
        Verb::Evaluate(options) => Printed::new(&workflow::evaluate::run(options, caller)?),
        Verb::Train(options) => Printed::untyped(&workflow::train::run(options, caller)?),
        Verb::Command(options) => Printed::new(&workflow::command::run(options, caller)?),
        Verb::Track(options) => Printed::new(&workflow::track::run(options, caller)?),
        Verb::FitSensor(options) => Printed::untyped(&workflow::sense::fit::run(options, caller)?),
        Verb::Sense(options) => Printed::untyped(&workflow::sense::run(options, caller)?),
        Verb::IdentifyServo(options) => Printed::untyped(&workflow::identify_servo::run(options, caller)?),
        Verb::Study(arguments) => Printed::untyped(&study::verb(arguments, &program.passed_on(), caller)?),
        Verb::Run(options) => Printed::untyped(&study::run(options, &program.passed_on(), caller)?),
        Verb::Demo(arguments) => {
            Printed::untyped(&study::demo::run(arguments, &program.passed_on(), caller)?)
        }
        Verb::Rig(arguments) => rig::run(arguments, caller),
        Verb::Arm(arguments) => arm::run(arguments, caller),
        Verb::Completions(arguments) => {
            manual::completions(arguments, Program::command());
            Ok(Printed::nothing())
        }
        Verb::Man(arguments) => Printed::untyped(&manual::man(arguments, Program::command(), caller)?),
        Verb::Watchdog { rig } => watchdog::watch(rig).map(|()| Printed::nothing()),
    }
}
