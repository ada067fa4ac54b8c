//! The program `hysteron`.

use std::process::ExitCode;

use hysteron_cli::{Invocation, run_program};

fn main() -> ExitCode {
    ExitCode::from(run_program(&Invocation::of_process()))
}
