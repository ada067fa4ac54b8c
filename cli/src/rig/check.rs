//! `hysteron rig check`: who is on the bus, and is it fit to run?

use std::path::PathBuf;

use hysteron_rig::LiveRig;
use hysteron_rig::bus::{ServoReport, list_ports};
use hysteron_rig::config::RigConfig;

use crate::terminal::say;

const HELP: &str = "\
Without --rig, lists the serial ports and which of them speak to servos. With it, opens the rig's port and compares \
what is there with what the rig file says: ids, model, supply, temperature, hardware errors; everything wrong is told \
at once. Then waits for the tracker's first pose. Nothing moves. docs/rig.md says how to wire a rig and how to find each \
key of its file.

Examples:
  hysteron rig check
  hysteron rig check --rig my-rig.toml
  hysteron rig check --rig my-rig.toml --release

Exit codes: 0 fit to run, 1 not, 2 bad input.";

/// A servo answers again about 0.3 s after a restart; the manual gives no time [ms].
const RESTART_MS: u64 = 500;

/// List serial ports; check servos and tracker of a rig
#[derive(Debug, clap::Args)]
#[command(after_help = HELP)]
pub struct Arguments {
    /// Rig file
    #[arg(long, value_name = "RIG")]
    rig: Option<PathBuf>,
    /// Restart every servo first: clears hardware errors whose cause is gone
    #[arg(long, requires = "rig")]
    reboot: bool,
    /// Switch the torque of every servo off, for example where a lost cable has left it on
    #[arg(long, requires = "rig")]
    release: bool,
}

/// Carries out the verb.
pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let ports = list_ports()?;
    say(format_args!("serial ports: {}", ports.len()));
    for port in &ports {
        let converter = port.converter.unwrap_or("-");
        say(format_args!("  {:<20} {converter:<12} {}", port.path.display(), port.description));
        if let Some(advice) = port.advice() {
            say(format_args!("    {advice}"));
        }
    }
    let Some(path) = &arguments.rig else { return Ok(()) };
    let rig = RigConfig::read(path)?;
    let mut hardware = LiveRig::open(&rig)?;
    if arguments.reboot {
        for id in rig.ids() {
            hardware.bus().reboot(id)?;
        }
        std::thread::sleep(std::time::Duration::from_millis(RESTART_MS));
    }
    if arguments.release {
        hardware.bus().disable_torque()?;
        say("torque off");
    }
    let reports = hardware.bus().self_check(&rig)?;
    print(&reports);
    if rig.tracker.is_some() {
        hardware.wait_for_pose()?;
        say("tracker: poses arrive");
    }
    Ok(())
}

fn print(reports: &[ServoReport]) {
    say("servo   model   firmware   mode   supply [V]   temperature [C]   torque   position [ticks]");
    for servo in reports {
        say(format_args!(
            "{:>5}{:>8}{:>11}{:>7}{:>13.1}{:>18.0}{:>9}{:>19}",
            servo.id,
            servo.model,
            servo.firmware,
            servo.mode,
            servo.voltage_v,
            servo.temperature_degc,
            if servo.torque_on { "on" } else { "off" },
            servo.position
        ));
    }
}
