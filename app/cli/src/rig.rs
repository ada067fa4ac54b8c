//! `hysteron rig`: the words of its verbs.

use hysteron_workflow::shared::outcome::Printed;
use hysteron_workflow::{Context, rig};

/// Servos and tracker, real or emulated
///
/// A new rig: check it, calibrate it, then `hysteron record`. Without hardware, `hysteron rig emulate` replaces
/// it: programs find the same servos on a serial port, and the same tracker on a TCP port. docs/rig.md is the guide.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    #[command(subcommand)]
    verb: Verb,
}

/// Verbs of the rig.
#[derive(Debug, clap::Subcommand)]
enum Verb {
    #[command(after_help = include_str!("help/rig-check.txt"))]
    Check(rig::check::Options),
    #[command(after_help = include_str!("help/rig-calibrate.txt"))]
    Calibrate(rig::calibrate::Options),
    #[command(after_help = include_str!("help/rig-emulate.txt"))]
    Emulate(rig::emulate::Options),
    #[command(after_help = include_str!("help/rig-recover.txt"))]
    Recover(rig::recover::Options),
}

/// Runs the verb.
pub fn run(arguments: &Arguments, context: &Context) -> anyhow::Result<Printed> {
    match &arguments.verb {
        Verb::Check(options) => Printed::new(&rig::check::run(options, context)?),
        Verb::Calibrate(options) => Printed::new(&rig::calibrate::run(options, context)?),
        Verb::Emulate(options) => Printed::new(&rig::emulate::run(options, context)?),
        Verb::Recover(options) => Printed::new(&rig::recover::run(options, context)?),
    }
}
