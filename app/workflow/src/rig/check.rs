//! `hysteron rig check`: who is on the bus, and is it fit to run?

use std::path::{Path, PathBuf};

use std::collections::BTreeMap;

use hysteron_base::BadInput;
use hysteron_rig::LiveRig;
use hysteron_rig::bus::{PortInfo, RegisterBaseline, RegisterDifference, ServoBus, ServoReport, list_ports};
use hysteron_rig::calibration::Calibration;
use hysteron_rig::config::RigConfig;
use hysteron_rig::teleoperation::{Arms, ArmsConfig};
use hysteron_rig::tracker::TrackerSurvey;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::is_of_arms;
use crate::Context;

/// A servo answers again about 0.3 s after a restart; the manual gives no time [ms].
const RESTART_MS: u64 = 500;
/// How long the tracker is looked at [s]: 80 poses of one at 40 Hz.
const SURVEY_S: f64 = 2.0;

/// List serial ports; check servos, their registers and the tracker of a rig, or both arms
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    /// Rig file, or file of two arms
    #[cfg_attr(feature = "clap", arg(long, value_name = "RIG"))]
    pub rig: Option<PathBuf>,
    /// Calibration whose registers are expected [default: the file that the rig file names]
    #[cfg_attr(feature = "clap", arg(long, value_name = "FILE", requires = "rig"))]
    pub calibration: Option<PathBuf>,
    /// Restart every servo first: clears hardware errors whose cause is gone
    #[cfg_attr(feature = "clap", arg(long, requires = "rig"))]
    pub reboot: bool,
    /// Switch the torque of every servo off, for example where a lost cable has left it on
    #[cfg_attr(feature = "clap", arg(long, requires = "rig"))]
    pub release: bool,
    /// Write back the registers that differ from what is expected, after asking; switches the torque off first
    #[cfg_attr(feature = "clap", arg(long, requires = "rig"))]
    pub restore: bool,
    /// Write back without asking
    #[cfg_attr(feature = "clap", arg(long, requires = "restore"))]
    pub yes: bool,
}

/// The outcome of `rig check`.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Outcome {
    /// Serial ports of this machine.
    pub ports: Vec<Port>,
    /// Servos of a rig.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub servos: Option<Vec<ServoSummary>>,
    /// Tracker of a rig that has one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tracker: Option<TrackerSurvey>,
    /// Joints of two arms.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub joints: Option<usize>,
}

impl crate::shared::outcome::Outcome for Outcome {}

impl Outcome {
    fn of_ports(ports: Vec<Port>) -> Self {
        Self { ports, servos: None, tracker: None, joints: None }
    }
}

/// A serial port.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Port {
    /// Its device file.
    pub port: PathBuf,
    /// Its description by the system.
    pub description: String,
}

/// A servo as it answered.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct ServoSummary {
    /// Id on the bus.
    pub id: u8,
    /// Model number.
    pub model: u16,
    /// Supply voltage [V].
    pub supply_v: f64,
    /// Temperature [°C].
    pub temperature_c: f64,
    /// Whether its torque is on.
    pub is_torque_on: bool,
    /// Position [ticks].
    pub position_ticks: i32,
    /// Registers that a calibration stores, by name; empty for servos that have none.
    pub registers: BTreeMap<String, i64>,
}

impl ServoSummary {
    fn new(servo: &ServoReport) -> Self {
        Self {
            id: servo.id,
            model: servo.model,
            supply_v: servo.voltage_v,
            temperature_c: servo.temperature_degc,
            is_torque_on: servo.torque_on,
            position_ticks: servo.position,
            registers: servo.registers.to_keys(),
        }
    }
}

/// Carries out the verb.
///
/// # Errors
/// Bad input; a rig that is not fit to run.
pub fn run(options: &Options, context: &Context) -> anyhow::Result<Outcome> {
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
    match Calibration::read(path, rig) {
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
        None => Err(BadInput::new("--restore", "somebody to ask, or --yes", "neither").into()),
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
    let mut arms = Arms::open(&config)?;
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
    for doubt in &survey.doubts {
        tracing::warn!("tracker: {doubt}");
    }
}
