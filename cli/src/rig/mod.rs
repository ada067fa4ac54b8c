//! `hysteron rig`: what concerns the rig itself.

mod calibrate;
mod check;
mod recover;

/// Check, calibrate or emulate a rig
#[derive(Debug, clap::Args)]
pub struct Arguments {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Debug, clap::Subcommand)]
enum Verb {
    Check(check::Arguments),
    Calibrate(calibrate::Arguments),
    Recover(recover::Arguments),
}

/// Carries out the verb.
pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    match &arguments.verb {
        Verb::Check(arguments) => check::run(arguments),
        Verb::Calibrate(arguments) => calibrate::run(arguments),
        Verb::Recover(arguments) => recover::run(arguments),
    }
}
