//! `hysteron rig calibrate`: zero, slack and pretension of every tendon, and the tracker's frame.

use std::path::{Path, PathBuf};
use std::time::SystemTime;

use hysteron_base::{BadInput, Lock, file};
use hysteron_rig::calibration::{Calibration, calibrate};
use hysteron_rig::virtual_rig::SimulatedRig;
use hysteron_rig::{Hardware, LiveRig};
use hysteron_workflow::Caller;
use hysteron_workflow::record::source::{Source, calibration_path};
use hysteron_workflow::watchdog::WatchedRig;

use crate::interrupt;
use crate::terminal::say;

const HELP: &str = "\
Winds every tendon slowly until its load rises, twice: the corner of that line is where its slack ends, and the zero \
lies where it carries the pretension of the rig file. Then pulls every tendon a little and finds the robot's frame \
from the way the tip goes. Keep hands off; the tip moves by a centimetre, each tendon by up to \
calibration.search_max_mm. Takes about a minute, longer with more slack. However it ends, by error, Ctrl-C or kill -9, the torque is off, also with at_end = \"hold\".

Writes a dated file; the calibration that was there is kept beside it, under its date. A calibration is only used with the servos, pulleys and directions that it was made with. docs/rig.md says \
what a good result looks like.

Examples:
  hysteron rig calibrate --rig my-rig.toml
  hysteron rig calibrate --rig virtual:typical --out out/calibration.toml

Exit codes: 0 done, 1 failed (the message says which tendon and why; nothing is written), 2 bad input.";

/// Find zero, slack and pretension of every tendon, and the tracker's frame
#[derive(Debug, clap::Args)]
#[command(after_help = HELP)]
pub struct Arguments {
    /// Rig file, or virtual:PRESET
    #[arg(long, value_name = "RIG")]
    rig: PathBuf,
    /// Calibration to write [default: the file that the rig file names]
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Seed of a virtual rig
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
}

/// Carries out the verb.
pub fn run(arguments: &Arguments, caller: &Caller) -> anyhow::Result<()> {
    let source = Source::read(&arguments.rig)?;
    let out = match (&source, &arguments.out) {
        (Source::Live { rig, .. }, named) => calibration_path(rig, named.as_ref()),
        (Source::Virtual { .. }, Some(out)) => out.clone(),
        (Source::Virtual { .. }, None) => {
            let expected = "a file for the calibration of a virtual rig";
            return Err(BadInput::new("--out", expected, "none").into());
        }
    };
    let _lock = Lock::file(&out)?;
    let before = earlier(&out)?;
    interrupt::listen()?;
    let mut tell = |line: &str| say(line);
    let date = humantime::format_rfc3339_seconds(SystemTime::now()).to_string();
    let calibration = match &source {
        Source::Live { rig, .. } => {
            let mut hardware = LiveRig::open(rig)?;
            // What is not fit to run needs nobody to watch it.
            hardware.prepare()?;
            let mut hardware = WatchedRig::new(hardware, &arguments.rig, caller)?;
            let found = calibrate(&mut *hardware, rig, date, &interrupt::is_asked, &mut tell)?;
            hardware.close();
            found
        }
        Source::Virtual { rig, robot, .. } => {
            let mut hardware = SimulatedRig::new(robot, rig, arguments.seed);
            calibrate(&mut hardware, rig, date, &interrupt::is_asked, &mut tell)?
        }
    };
    if let Some((aside, text)) = before {
        file::write_bytes(&aside, text)?;
        say(format_args!("the calibration before: {}", aside.display()));
    }
    file::write_bytes(&out, calibration.to_toml())?;
    print(&calibration);
    say(format_args!("written: {}", out.display()));
    Ok(())
}

/// The calibration that is to be replaced: where it is kept, under its date, and its text. Anything else is not
/// replaced.
fn earlier(out: &Path) -> anyhow::Result<Option<(PathBuf, String)>> {
    if !out.exists() {
        return Ok(None);
    }
    let text = file::read_text(out)?;
    let found = Calibration::from_toml(&text).map_err(|_| {
        BadInput::new(out.display().to_string(), "a calibration, or a new file", "another file")
            .hint("choose another --out, or another calibration.file in the rig file")
    })?;
    let date: String = found.date.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '-' }).collect();
    let named = |number: u32| match number {
        0 => out.with_extension(format!("{date}.toml")),
        _ => out.with_extension(format!("{date}-{number}.toml")),
    };
    let is_free = |path: &PathBuf| !path.exists() || file::read_text(path).is_ok_and(|there| there == text);
    Ok((0..).map(named).find(is_free).map(|aside| (aside, text)))
}

fn print(calibration: &Calibration) {
    say("servo   zero [ticks]   slack ends at [mm]");
    for channel in &calibration.channels {
        say(format_args!("{:>5}{:>15}{:>21.3}", channel.servo_id, channel.zero, 1e3 * channel.slack_end));
    }
}
