//! `hysteron rig check`: who is on the bus, and is it fit to run?

use std::path::PathBuf;

use hysteron_base::json;
use hysteron_rig::LiveRig;
use hysteron_rig::bus::{ServoReport, list_ports};
use hysteron_rig::config::RigConfig;
use serde_json::Value;

use crate::Caller;

/// A servo answers again about 0.3 s after a restart; the manual gives no time [ms].
const RESTART_MS: u64 = 500;

/// List serial ports; check servos and tracker of a rig
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    /// Rig file
    #[cfg_attr(feature = "clap", arg(long, value_name = "RIG"))]
    pub rig: Option<PathBuf>,
    /// Restart every servo first: clears hardware errors whose cause is gone
    #[cfg_attr(feature = "clap", arg(long, requires = "rig"))]
    pub reboot: bool,
    /// Switch the torque of every servo off, for example where a lost cable has left it on
    #[cfg_attr(feature = "clap", arg(long, requires = "rig"))]
    pub release: bool,
}

/// Carries out the verb.
///
/// # Errors
/// Bad input; a rig that is not fit to run.
pub fn run(options: &Options, caller: &Caller) -> anyhow::Result<Value> {
    let ports = list_ports()?;
    caller.say(format_args!("serial ports: {}", ports.len()));
    for port in &ports {
        let converter = port.converter.unwrap_or("-");
        caller.say(format_args!("  {:<20} {converter:<12} {}", port.path.display(), port.description));
        if let Some(advice) = port.advice() {
            caller.say(format_args!("    {advice}"));
        }
    }
    let listed: Vec<Value> =
        ports.iter().map(|port| json!({ "port": port.path, "description": port.description })).collect();
    let Some(path) = &options.rig else { return Ok(json!({ "ports": listed })) };
    let rig = RigConfig::read(path)?;
    let mut hardware = LiveRig::open(&rig)?;
    if options.reboot {
        for id in rig.ids() {
            hardware.bus().reboot(id)?;
        }
        std::thread::sleep(std::time::Duration::from_millis(RESTART_MS));
    }
    if options.release {
        hardware.bus().disable_torque()?;
        caller.say("torque off");
    }
    let reports = hardware.bus().self_check(&rig.servo_bounds())?;
    print(&reports, caller);
    if rig.tracker.is_some() {
        hardware.wait_for_pose()?;
        caller.say("tracker: poses arrive");
    }
    let servos = reports.iter().map(|servo| {
        json!({
            "id": servo.id, "model": servo.model, "supply_v": servo.voltage_v,
            "temperature_c": servo.temperature_degc, "is_torque_on": servo.torque_on, "position_ticks": servo.position,
        })
    });
    Ok(json!({ "ports": listed, "servos": servos.collect::<Vec<_>>() }))
}

fn print(reports: &[ServoReport], caller: &Caller) {
    caller.say("servo   model   firmware   mode   supply [V]   temperature [C]   torque   position [ticks]");
    for servo in reports {
        caller.say(format_args!(
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
