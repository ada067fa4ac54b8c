//! `hysteron rig`: everything that concerns servos and tracker, real or emulated.

mod emulate;

/// Servos and tracker, real or emulated
///
/// `hysteron rig emulate` stands in for the hardware: other programs find servos on a serial port.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    #[command(subcommand)]
    step: Step,
}

/// What to do with the rig.
#[derive(Debug, clap::Subcommand)]
enum Step {
    Emulate(emulate::Arguments),
}

/// Carries out the verb.
pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    match &arguments.step {
        Step::Emulate(arguments) => emulate::run(arguments),
    }
}
