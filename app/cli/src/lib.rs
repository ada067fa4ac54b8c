//! The program `hysteron` as a library: arguments, progress and errors; what verbs do is in `hysteron-workflow`.
//!
//! Every failure comes back here as one error, which decides the exit code: 2 for a user error, 1 for
//! everything else. [`run_program`] is all of the program; [`command`] and [`run_verb`] serve those who run its verbs in a
//! process of their own, as the Python package does.

mod arguments;
mod arm;
mod context;
mod failure;
mod interrupt;
mod invocation;
mod limits;
mod manual;
mod progress;
mod rig;
mod shards;
mod study;
mod terminal;

use clap::CommandFactory;
use hysteron_workflow::shared::outcome::Printed;
use hysteron_workflow::{self as workflow, Context, shared::watchdog};

use arguments::{Program, Verb};
pub use invocation::Invocation;

/// The command line: verbs, their options and their help.
pub fn command() -> clap::Command {
    Program::command()
}

/// The program: reads the arguments, runs the verb, prints its outcome or error, and returns the exit code.
pub fn run_program(invocation: &Invocation) -> u8 {
    let program = match Program::typed(&invocation.arguments) {
        Ok(program) => program,
        Err(code) => return code,
    };
    terminal::start_log(program.verbosity());
    if program.is_json() {
        terminal::use_json();
    }
    let context = context::by_terminal(invocation, program.overwrite());
    match prepare(&program).and_then(|()| run(&program, invocation, &context)) {
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
            failure::exit_code(&error)
        }
    }
}

/// The verb of these arguments, run in the process of the caller: nothing is printed but through the context, and signals
/// stay with the caller. `context` is made from what [`Invocation`] says of results and the watchdog, and from `--overwrite`.
///
/// # Errors
/// `BadInput` for arguments that cannot be used; those of the verb.
pub fn run_verb<'a>(
    invocation: &Invocation,
    context: impl FnOnce(ContextParts) -> Context<'a>,
) -> Result<Printed, workflow::WorkflowError> {
    terminal::use_json();
    let program = Program::of_caller(&invocation.arguments)?;
    let context = context(ContextParts {
        command: invocation.command_line(),
        overwrite: program.overwrite(),
        watchdog: invocation.watchdog(),
    });
    Ok(run(&program, invocation, &context)?)
}

/// All of a [`Context`] but its progress.
#[derive(Debug)]
pub struct ContextParts {
    /// See [`Context::command`].
    pub command: String,
    /// See [`Context::overwrite`].
    pub overwrite: bool,
    /// See [`Context::watchdog`].
    pub watchdog: Option<Vec<std::ffi::OsString>>,
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
fn run(program: &Program, invocation: &Invocation, context: &Context) -> anyhow::Result<Printed> {
    let relaunch = || invocation.relaunch(program.passed_on());
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
        Verb::Shards(arguments) => shards::run(arguments, context),
        Verb::Train(options) => Printed::new(&workflow::tendon::train::run(options, context)?),
        Verb::Command(options) => Printed::new(&workflow::tendon::command::run(options, context)?),
        Verb::Track(options) => Printed::new(&workflow::tendon::track::run(options, context)?),
        Verb::FitSensor(options) => Printed::new(&workflow::tendon::fit_sensor::run(options, context)?),
        Verb::Sense(options) => Printed::new(&workflow::tendon::sense::run(options, context)?),
        Verb::IdentifyServo(options) => Printed::new(&workflow::rig::identify_servo::run(options, context)?),
        Verb::Study(arguments) => study::verb(arguments, &relaunch(), context),
        Verb::Run(options) => Printed::new(&study::run(options, &relaunch(), context)?),
        Verb::Demo(arguments) => Printed::new(&study::demo::run(arguments, &relaunch(), context)?),
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
