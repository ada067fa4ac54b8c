//! The rig file that an emulator writes for its clients.

use std::net::SocketAddr;
use std::path::{Path, PathBuf};

use hysteron_base::{BadInput, file};
use hysteron_virtual_rig::virtual_rig::{VirtualRobot, rig_file};

use super::options::Options;

/// Name of the rig file in the folder of an emulator.
const RIG_FILE: &str = "rig.toml";
/// Timing lines of the preset's rig file for hardware, each with its replacement for an emulator: it shares a
/// computer with its clients, and a delay of that computer is no fault of the servos.
pub(crate) const PATIENT: [(&str, &str); 3] = [
    ("reply_timeout_ms = 4.0", "reply_timeout_ms = 100.0"),
    ("bus_watchdog_ms = 200.0", "bus_watchdog_ms = 2540.0"),
    ("stale_ms = 300.0", "stale_ms = 2000.0"),
];
/// Keys that differ between runs of one emulator.
const OF_A_RUN: [&str; 2] = ["address = ", "baud = "];

/// Refuses a folder whose rig file is not one that this emulator would write: it belongs to another rig.
pub(super) fn check(folder: &Path, robot: &VirtualRobot) -> anyhow::Result<()> {
    let path = folder.join(RIG_FILE);
    if !path.exists() {
        return Ok(());
    }
    let (found, own) = (file::read_text(&path)?, patient_rig_file(robot));
    let lasting = |text: &str| -> Vec<String> {
        let is_lasting = |line: &&str| !OF_A_RUN.iter().any(|key| line.starts_with(key));
        text.lines().filter(is_lasting).map(str::to_owned).collect()
    };
    if lasting(&found) == lasting(&own) {
        return Ok(());
    }
    Err(BadInput::new(path.display().to_string(), "the rig file of this virtual robot, or none", "another")
        .hint("move it away, or choose another --dir")
        .into())
}

/// The rig file of a virtual robot on ports.
fn patient_rig_file(robot: &VirtualRobot) -> String {
    PATIENT.iter().fold(rig_file(robot), |text, (from, to)| text.replace(from, to))
}

/// The rig file with which this program finds what is emulated.
pub(super) fn write(options: &Options, robot: &VirtualRobot, tracker: SocketAddr) -> anyhow::Result<PathBuf> {
    let text = patient_rig_file(robot)
        .replace("127.0.0.1:18944", &tracker.to_string())
        .replace("baud = 1000000", &format!("baud = {}", options.baud));
    let path = options.dir.join(RIG_FILE);
    file::write_bytes(&path, text)?;
    Ok(path)
}
