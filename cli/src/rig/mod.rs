//! `hysteron rig`: everything that concerns servos and tracker, real or emulated.

mod calibrate;
mod check;
mod emulate;
mod recover;

use hysteron_workflow::Caller;

/// Servos and tracker, real or emulated
///
/// A new rig: check it, calibrate it, then `hysteron record`. Without hardware, `hysteron rig emulate` stands in for
/// it: programs find the same servos on a serial port, and the same tracker on a TCP port. docs/rig.md is the guide.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    #[command(subcommand)]
    step: Step,
}

/// What to do with the rig.
#[derive(Debug, clap::Subcommand)]
enum Step {
    Check(check::Arguments),
    Calibrate(calibrate::Arguments),
    Emulate(emulate::Arguments),
    Recover(recover::Arguments),
}

/// Carries out the verb.
pub fn run(arguments: &Arguments, caller: &Caller) -> anyhow::Result<()> {
    match &arguments.step {
        Step::Check(arguments) => check::run(arguments),
        Step::Calibrate(arguments) => calibrate::run(arguments, caller),
        Step::Emulate(arguments) => emulate::run(arguments),
        Step::Recover(arguments) => recover::run(arguments),
    }
}
