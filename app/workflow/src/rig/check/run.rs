//! The check: ports, servos and their registers, tracker; or both arms.

use std::path::Path;

use hysteron_base::BadInput;
use hysteron_rig::LiveRig;
use hysteron_rig::bus::{PortInfo, RegisterBaseline, RegisterDifference, ServoBus, ServoReport, list_ports};
use hysteron_rig::calibration::RigCalibration;
use hysteron_rig::config::RigConfig;
use hysteron_rig::teleoperation::{ArmPair, ArmsConfig};
use hysteron_rig::tracker::TrackerSurvey;

use super::options::Options;
use super::outcome::{Outcome, Port, ServoSummary};
use crate::rig::is_of_arms;
use crate::{Context, WorkflowError};

/// A servo answers again about 0.3 s after a restart; the manual gives no time [ms].
const RESTART_MS: u64 = 500;
/// How long the tracker is looked at [s]: 80 poses of one at 40 Hz.
const SURVEY_S: f64 = 2.0;

/// Runs the verb.
///
/// # Errors
/// Bad input; a rig that is not fit to run.
pub fn run(options: &Options, context: &Context) -> Result<Outcome, WorkflowError> {
    Ok(check(options, context)?)
}

fn check(options: &Options, context: &Context) -> anyhow::Result<Outcome> {
    let listed = print_ports(context)?;
    let Some(path) = &options.rig else { return Ok(Outcome::of_ports(listed)) };
    if is_of_arms(path)? {
        return check_arms(path, options, listed, context);
    }
    let rig = RigConfig::read(path)?;
    let baseline = expected_registers(options, &rig)?;
    let mut hardware = LiveRig::open(&rig)?;
    let bus = hardware.bus();
    restart_and_release(bus, options, context)?;
    let reports = bus.self_check(&rig.servo_bounds())?;
    print(&reports, context);
    if check_registers(bus, &baseline, options, context)? {
        bus.self_check(&rig.servo_bounds())?;
        bus.accept_registers(&baseline)?;
    }
    let survey = hardware.survey_tracker(SURVEY_S)?;
    if let Some(survey) = &survey {
        print_survey(survey, context);
    }
    let servos = reports.iter().map(ServoSummary::new).collect();
    Ok(Outcome { servos: Some(servos), tracker: survey, ..Outcome::of_ports(listed) })
}

fn print_ports(context: &Context) -> anyhow::Result<Vec<Port>> {
    let ports = list_ports()?;
    context.print(format_args!("serial ports: {}", ports.len()));
    for port in &ports {
        let converter = port.converter.unwrap_or("-");
        context.print(format_args!("  {:<20} {converter:<12} {}", port.path.display(), port.description));
        if let Some(advice) = port.advice() {
            context.print(format_args!("    {advice}"));
        }
    }
    let port = |port: &PortInfo| Port { port: port.path.clone(), description: port.description.clone() };
    Ok(ports.iter().map(port).collect())
}

/// Reference for the registers of a rig's servos: the values that its calibration stored; before there is
/// one, the factory's.
fn expected_registers(options: &Options, rig: &RigConfig) -> anyhow::Result<RegisterBaseline> {
    let path = options.calibration.as_ref().unwrap_or(&rig.calibration.file);
    if options.calibration.is_none() && !path.exists() {
        return Ok(RegisterBaseline::Factory);
    }
    match RigCalibration::read(path, rig) {
        Ok(calibration) => Ok(calibration.register_baseline()),
        // A rig file that has changed since is no reason not to look at the rig.
        Err(error) if options.calibration.is_none() => {
            tracing::warn!("{error}; registers are compared with the factory's values");
            Ok(RegisterBaseline::Factory)
        }
        Err(error) => Err(error.into()),
    }
}

fn restart_and_release(bus: &mut ServoBus, options: &Options, context: &Context) -> anyhow::Result<()> {
    if options.reboot {
        for id in bus.ids().to_vec() {
            bus.reboot(id)?;
        }
        std::thread::sleep(std::time::Duration::from_millis(RESTART_MS));
    }
    if options.release {
        bus.disable_torque()?;
        context.print("torque off");
    }
    Ok(())
}

/// Prints how the registers differ from what is expected, and writes them back if that was asked for and confirmed.
/// Returns whether it did.
///
/// # Errors
/// If they differ and stay so.
fn check_registers(
    bus: &mut ServoBus,
    baseline: &RegisterBaseline,
    options: &Options,
    context: &Context,
) -> anyhow::Result<bool> {
    for line in bus.settings_to_change() {
        context.print(format_args!("note: {line}"));
    }
    let different = bus.register_differences(baseline)?;
    if different.is_empty() {
        context.print("registers: as expected");
        return Ok(false);
    }
    if !options.restore {
        bus.accept_registers(baseline)?;
        return Ok(false);
    }
    different.iter().for_each(|one| context.print(one));
    confirm(&different, options, context)?;
    bus.restore_registers(&different)?;
    context.print(format_args!("registers written back: {}; torque off", different.len()));
    Ok(true)
}

/// Asks before a servo's registers are written.
fn confirm(different: &[RegisterDifference], options: &Options, context: &Context) -> anyhow::Result<()> {
    if options.yes {
        return Ok(());
    }
    let question = format!("Switch the torque off and write back {} registers?", different.len());
    match context.confirm(&question) {
        Some(true) => Ok(()),
        Some(false) => anyhow::bail!("nothing was written"),
        None => Err(BadInput::new("--restore", "a terminal to ask in, or --yes", "neither").into()),
    }
}

/// The same for two arms.
fn check_arms(
    path: &Path,
    options: &Options,
    listed: Vec<Port>,
    context: &Context,
) -> anyhow::Result<Outcome> {
    if options.calibration.is_some() {
        let expected = "no calibration: the file of the arms states their registers";
        return Err(BadInput::new("--calibration", expected, "one").into());
    }
    let config = ArmsConfig::read(path)?;
    let mut arms = ArmPair::open(&config)?;
    for bus in arms.buses() {
        restart_and_release(bus, options, context)?;
    }
    let mut is_written = false;
    for (arm, baseline, bus) in arms.examine()? {
        context.print(format_args!("{arm}: {} servos answer", bus.ids().len()));
        is_written |= check_registers(bus, &baseline, options, context)?;
    }
    if is_written {
        for (_, baseline, bus) in arms.examine()? {
            bus.accept_registers(&baseline)?;
        }
    }
    Ok(Outcome { joints: Some(config.joints.len()), ..Outcome::of_ports(listed) })
}

fn print(reports: &[ServoReport], context: &Context) {
    context
        .print("servo   model   firmware   mode   supply [V]   temperature [C]   torque   position [ticks]");
    for servo in reports {
        context.print(format_args!(
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

fn print_survey(survey: &TrackerSurvey, context: &Context) {
    let [x, y, z] = survey.position_mm;
    let [qw, qx, qy, qz] = survey.orientation_wxyz;
    context.print(format_args!(
        "tracker: {} poses at {:.1} Hz; position {x:.2} {y:.2} {z:.2} mm, orientation {qw:.4} {qx:.4} {qy:.4} {qz:.4}",
        survey.n_poses, survey.rate_hz
    ));
    context.print(format_args!(
        "tracker: noise {:.3} mm, jitter of stamps {:.2} ms, longest gap {:.1} ms",
        survey.noise_mm, survey.jitter_ms, survey.longest_gap_ms
    ));
    for warning in &survey.warnings {
        tracing::warn!("tracker: {warning}");
    }
}
