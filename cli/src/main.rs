//! The program `hysteron`: arguments, progress and reports; no science.
//!
//! One module per verb. Each reads its files, calls the libraries and writes whole files; what fails comes back
//! here as one error, which decides the exit code: 2 for input that a person can mend, 1 for everything else.

mod adapt;
mod arguments;
mod arm;
mod check;
mod command;
mod evaluate;
mod failure;
mod figures;
mod fit_material;
mod fit_residual;
mod generate;
mod identify;
mod inputs;
mod interrupt;
mod manual;
mod mesh;
mod network;
mod number;
mod outputs;
mod paper_design;
mod paths;
mod plan;
mod progress;
mod reach;
mod record;
mod rig;
mod run;
mod simulate;
mod study;
mod target;
mod terminal;
mod track;
mod train;
mod unfinished;
mod watchman;

use std::process::ExitCode;

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
    program.allow_overwriting();
    let done = program.use_threads().and_then(|()| match &program.verb {
        Verb::Simulate(arguments) => simulate::run(arguments),
        Verb::Reach(arguments) => reach::run(arguments),
        Verb::Mesh(arguments) => mesh::run(arguments),
        Verb::Check(arguments) => check::run(arguments),
        Verb::Record(arguments) => record::run(arguments),
        Verb::FitMaterial(arguments) => fit_material::run(arguments),
        Verb::Identify(arguments) => identify::run(arguments),
        Verb::FitResidual(arguments) => fit_residual::run(arguments),
        Verb::Adapt(arguments) => adapt::run(arguments),
        Verb::Generate(arguments) => generate::run(arguments),
        Verb::Target(arguments) => target::run(arguments),
        Verb::Evaluate(arguments) => evaluate::run(arguments),
        Verb::Train(arguments) => train::run(arguments),
        Verb::Command(arguments) => command::run(arguments),
        Verb::Track(arguments) => track::run(arguments),
        Verb::Rig(arguments) => rig::run(arguments),
        Verb::Arm(arguments) => arm::run(arguments),
        Verb::Run(arguments) => study::run(arguments, &program.passed_on()),
        Verb::Demo(arguments) => study::demo::run(arguments, &program.passed_on()),
        Verb::Completions(arguments) => {
            manual::completions(arguments);
            Ok(())
        }
        Verb::Man(arguments) => manual::man(arguments),
        Verb::Watchman(arguments) => watchman::run(arguments),
    });
    match done {
        Ok(()) => {
            terminal::conclude();
            ExitCode::SUCCESS
        }
        Err(error) => {
            if failure::is_told(&error) {
                tracing::warn!("{error:#}");
            } else {
                terminal::complain(&error);
            }
            ExitCode::from(failure::exit_code(&error))
        }
    }
}
