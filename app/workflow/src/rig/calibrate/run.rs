//! The calibration: the rig or its simulation, the procedure, the file.

use std::path::{Path, PathBuf};
use std::time::SystemTime;

use hysteron_base::{BadInput, Lock, file};
use hysteron_rig::bus::RegisterBaseline;
use hysteron_rig::calibration::{RigCalibration, calibrate};
use hysteron_rig::{Hardware, LiveRig};
use hysteron_virtual_rig::virtual_rig::SimulatedRig;

use super::options::Options;
use super::outcome::Outcome;
use crate::rig::record::source::{Source, calibration_path};
use crate::shared::watchdog::WatchdogGuard;
use crate::{Context, WorkflowError};

/// Runs the verb.
///
/// # Errors
/// Bad input; a tendon or a tracker that cannot be calibrated.
pub fn run(options: &Options, context: &Context) -> Result<Outcome, WorkflowError> {
    Ok(calibrate_rig(options, context)?)
}

fn calibrate_rig(options: &Options, context: &Context) -> anyhow::Result<Outcome> {
    let source = Source::read(&options.rig)?;
    let out = match (&source, &options.out) {
        (Source::Live { rig, .. }, named) => calibration_path(rig, named.as_ref()),
        (Source::Virtual { .. }, Some(out)) => out.clone(),
        (Source::Virtual { .. }, None) => {
            let expected = "a file for the calibration of a virtual rig";
            return Err(BadInput::new("--out", expected, "none").into());
        }
    };
    let _lock = Lock::file(&out)?;
    let before = earlier(&out)?;
    match &source {
        Source::Live { .. } => context.listen_on_rig(),
        Source::Virtual { .. } => context.listen(),
    }
    let mut log = |line: &str| context.print(line);
    let date = humantime::format_rfc3339_seconds(SystemTime::now()).to_string();
    let calibration = match &source {
        Source::Live { rig, .. } => {
            let registers = expected_registers(options, before.as_ref().map(|before| &before.calibration));
            let mut hardware = LiveRig::open(rig)?.expecting(registers);
            // A rig that is not fit to run needs no watchdog.
            hardware.prepare()?;
            let mut hardware = WatchdogGuard::new(hardware, &options.rig, context)?;
            let found = calibrate(&mut *hardware, rig, date, &|| context.is_cancelled(), &mut log)?;
            hardware.close();
            found
        }
        Source::Virtual { rig, robot, .. } => {
            let mut hardware = SimulatedRig::new(robot, rig, options.seed);
            calibrate(&mut hardware, rig, date, &|| context.is_cancelled(), &mut log)?
        }
    };
    if let Some(EarlierCalibration { aside, text, .. }) = before {
        file::write_bytes(&aside, text)?;
        context.print(format_args!("the calibration before: {}", aside.display()));
    }
    file::write_bytes(&out, calibration.to_toml())?;
    print(&calibration, context);
    context.print(format_args!("written: {}", out.display()));
    Ok(Outcome::new(out, &calibration))
}

/// Reference for the servos' registers: the values of the calibration before, or the factory's.
fn expected_registers(options: &Options, before: Option<&RigCalibration>) -> RegisterBaseline {
    match before {
        _ if options.keep_registers => RegisterBaseline::AsFound,
        Some(before) => before.register_baseline(),
        None => RegisterBaseline::Factory,
    }
}

/// The calibration that is to be replaced.
struct EarlierCalibration {
    calibration: RigCalibration,
    /// Where it is kept, under its date.
    aside: PathBuf,
    text: String,
}

/// The calibration that is to be replaced. Anything else is not replaced.
fn earlier(out: &Path) -> anyhow::Result<Option<EarlierCalibration>> {
    if !out.exists() {
        return Ok(None);
    }
    let text = file::read_text(out)?;
    let found = RigCalibration::from_toml(&text).map_err(|_| {
        BadInput::new(out.display().to_string(), "a calibration, or a new file", "another file")
            .hint("choose another --out, or another calibration.file in the rig file")
    })?;
    let date: String = found.date.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '-' }).collect();
    let named = |number: u32| match number {
        0 => out.with_extension(format!("{date}.toml")),
        _ => out.with_extension(format!("{date}-{number}.toml")),
    };
    let is_free = |path: &PathBuf| !path.exists() || file::read_text(path).is_ok_and(|there| there == text);
    Ok((0..).map(named).find(is_free).map(|aside| EarlierCalibration { calibration: found, aside, text }))
}

fn print(calibration: &RigCalibration, context: &Context) {
    context.print("servo   zero [ticks]   slack ends at [mm]");
    for channel in &calibration.channels {
        context.print(format_args!(
            "{:>5}{:>15}{:>21.3}",
            channel.servo_id,
            channel.zero,
            1e3 * channel.slack_end
        ));
    }
}
