//! The program `hysteron`: arguments, progress and errors; what verbs do is in `hysteron-workflow`.
//!
//! Every failure comes back here as one error, which decides the exit code: 2 for a user error, 1 for
//! everything else.

mod arguments;
mod arm;
mod context;
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
use hysteron_workflow::shared::outcome::Printed;
use hysteron_workflow::{self as workflow, Context, shared::watchdog};

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
    let context = context::by_terminal(program.overwrite());
    match prepare(&program).and_then(|()| run(&program, &context)) {
        Ok(outcome) => {
            terminal::print_outcome(&outcome);
            terminal::exit_code_of_printing()
        }
        Err(error) => {
            if let Some(refused) = refused(&error) {
                terminal::print_outcome(&refused.outcome);
            }
            if failure::is_reported(&error) {
                tracing::warn!("{error:#}");
            } else {
                terminal::report_error(&error);
            }
            ExitCode::from(failure::exit_code(&error))
        }
    }
}

/// The recordings that `check` refused, if that is the error.
fn refused(error: &anyhow::Error) -> Option<&workflow::tendon::check::Refused> {
    error.downcast_ref::<workflow::WorkflowError>()?.downcast_ref()
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
fn run(program: &Program, context: &Context) -> anyhow::Result<Printed> {
    match &program.verb {
        Verb::Simulate(options) => Printed::new(&workflow::tendon::simulate::run(options, context)?),
        Verb::Reach(options) => Printed::new(&workflow::tendon::reach::run(options, context)?),
        Verb::Mesh(options) => Printed::new(&workflow::tendon::mesh::run(options, context)?),
        Verb::Reduce(options) => Printed::new(&workflow::tendon::reduce::run(options, context)?),
        Verb::Check(options) => Printed::new(&workflow::tendon::check::run(options, context)?),
        Verb::Record(options) => Printed::new(&workflow::rig::record::run(options, context)?),
        Verb::Import(options) => Printed::new(&workflow::import::run(options, context)?),
        Verb::FitMaterial(options) => Printed::new(&workflow::tendon::fit_material::run(options, context)?),
        Verb::Identify(options) => Printed::new(&workflow::tendon::identify::run(options, context)?),
        Verb::FitResidual(options) => Printed::new(&workflow::tendon::fit_residual::run(options, context)?),
        Verb::Adapt(options) => Printed::new(&workflow::tendon::adapt::run(options, context)?),
        Verb::Generate(options) => Printed::new(&workflow::tendon::generate::run(options, context)?),
        Verb::Target(options) => Printed::new(&workflow::tendon::target::run(options, context)?),
        Verb::Evaluate(options) => Printed::new(&workflow::tendon::evaluate::run(options, context)?),
        Verb::Train(options) => Printed::new(&workflow::tendon::train::run(options, context)?),
        Verb::Command(options) => Printed::new(&workflow::tendon::command::run(options, context)?),
        Verb::Track(options) => Printed::new(&workflow::tendon::track::run(options, context)?),
        Verb::FitSensor(options) => Printed::new(&workflow::tendon::fit_sensor::run(options, context)?),
        Verb::Sense(options) => Printed::new(&workflow::tendon::sense::run(options, context)?),
        Verb::IdentifyServo(options) => Printed::new(&workflow::rig::identify_servo::run(options, context)?),
        Verb::Study(arguments) => study::verb(arguments, &program.passed_on(), context),
        Verb::Run(options) => Printed::new(&study::run(options, &program.passed_on(), context)?),
        Verb::Demo(arguments) => Printed::new(&study::demo::run(arguments, &program.passed_on(), context)?),
        Verb::Rig(arguments) => rig::run(arguments, context),
        Verb::Arm(arguments) => arm::run(arguments, context),
        Verb::Completions(arguments) => {
            manual::completions(arguments, Program::command());
            Ok(Printed::nothing())
        }
        Verb::Man(arguments) => Printed::new(&manual::man(arguments, Program::command(), context)?),
        Verb::Watchdog { rig } => watchdog::watch(rig).map(|()| Printed::nothing()),
    }
}
