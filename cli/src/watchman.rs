//! The watchman: a second process that lets the servos go if the first one dies.
//!
//! Nothing in a process survives `kill -9`. So a run starts this program once more, with a hidden verb and a pipe
//! that nobody writes to: when the pipe closes without the word that all is well, the watchman opens the bus itself
//! and switches the torque off. It sits in a process group of its own, where Ctrl-C does not reach it.

use std::io::{Read, Write};
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::time::Instant;

use anyhow::Context;
use hysteron_rig::bus::ServoBus;
use hysteron_rig::config::{AtEnd, RigConfig};

/// What the run says when it has dealt with the torque itself.
const ALL_IS_WELL: u8 = b'.';
/// How long to go on trying to let go.
const PATIENCE_S: f64 = 10.0;

/// Let the servos of a rig go when stdin closes (started by `record`)
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Rig file
    rig: PathBuf,
}

/// Waits and, if need be, lets go.
pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let rig = RigConfig::read(&arguments.rig)?;
    let mut word = [0];
    if std::io::stdin().read_exact(&mut word).is_ok() && word[0] == ALL_IS_WELL {
        return Ok(());
    }
    let start = Instant::now();
    loop {
        let done = ServoBus::open(&rig.servos, &rig.ids(), start).and_then(|mut bus| bus.set_torque(false));
        match done {
            Ok(()) => return Ok(()),
            Err(error) if start.elapsed().as_secs_f64() > PATIENCE_S => {
                return Err(error).context("the run died, and the servos could not be let go");
            }
            Err(_) => std::thread::sleep(std::time::Duration::from_millis(20)),
        }
    }
}

/// A watchman on duty. Dropped without being dismissed, it lets the servos go; their port must be closed by then.
#[derive(Debug)]
pub struct Watchman {
    process: Child,
}

impl Watchman {
    /// Puts one on duty for a run on this rig; none where the torque is to be held anyway.
    pub fn start(rig_file: &std::path::Path, rig: &RigConfig) -> anyhow::Result<Option<Self>> {
        if rig.motion.at_end == AtEnd::Hold {
            return Ok(None);
        }
        let program = std::env::current_exe().context("finding this program")?;
        let mut command = Command::new(program);
        command.arg("--quiet").arg("watchman").arg(rig_file).stdin(Stdio::piped()).stdout(Stdio::null());
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(&mut command, 0);
        let process = command.spawn().context("starting the watchman")?;
        Ok(Some(Self { process }))
    }

    /// Sends it home: the run has dealt with the torque.
    pub fn dismiss(mut self) {
        if let Some(pipe) = &mut self.process.stdin {
            // If it is gone already, there is nobody to tell.
            let _ = pipe.write_all(&[ALL_IS_WELL]);
        }
    }
}

impl Drop for Watchman {
    fn drop(&mut self) {
        self.process.stdin = None;
        let _ = self.process.wait();
    }
}
