//! The watchdog process: a second process that switches the torque off if the first one dies.
//!
//! Nothing in a process survives `kill -9`. So a run, or a calibration, starts a process that calls
//! [`watch`] (of the program: itself once more, with a hidden verb), with a pipe to which nothing is written: when the
//! pipe closes without the word that all is well, the watchdog process opens the bus itself and switches the torque
//! off, whatever `at_end` of the rig file is. It is in a process group of its own, where Ctrl-C does not reach it.

use std::io::{Read, Write};
use std::ops::{Deref, DerefMut};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Instant;

use anyhow::Context as _;
use hysteron_rig::bus::ServoBus;
use hysteron_rig::config::{RigConfig, ServoConfig};
use hysteron_rig::teleoperation::ArmsConfig;

use crate::Context;

/// Signal of the run that it has dealt with the torque itself, and of the watchdog process that it has read
/// the file.
const ALL_IS_WELL: u8 = b'.';
/// How long to retry switching the torque off.
const PATIENCE_S: f64 = 10.0;

/// The bus and the ids of the servos that a file of a rig, or of two arms, drives.
fn servos_of(path: &Path) -> anyhow::Result<(ServoConfig, Vec<u8>)> {
    Ok(if crate::rig::is_of_arms(path)? {
        let arms = ArmsConfig::read(path)?;
        let ids = arms.joints.iter().map(|joint| joint.follower.id).collect();
        (arms.follower, ids)
    } else {
        let rig = RigConfig::read(path)?;
        let ids = rig.ids();
        (rig.servos, ids)
    })
}

/// Runs the watchdog process: waits until stdin closes and, unless all was well, switches the torque off of
/// the servos that a file of a rig, or of two arms, drives.
///
/// # Errors
/// `BadInput` naming what is wrong in the file; a failure where the torque could not be switched off.
pub fn watch(file: &Path) -> anyhow::Result<()> {
    let (servos, ids) = servos_of(file)?;
    // A parent that has died meanwhile gets no answer: the torque is switched off next.
    let _ = std::io::stdout().write_all(&[ALL_IS_WELL]).and_then(|()| std::io::stdout().flush());
    let mut word = [0];
    if std::io::stdin().read_exact(&mut word).is_ok() && word[0] == ALL_IS_WELL {
        return Ok(());
    }
    let start = Instant::now();
    loop {
        let done = ServoBus::open(&servos, &ids, start).and_then(|mut bus| bus.disable_torque());
        match done {
            Ok(()) => return Ok(()),
            Err(error) if start.elapsed().as_secs_f64() > PATIENCE_S => {
                return Err(error).context("the run died, and the torque could not be switched off");
            }
            Err(_) => std::thread::sleep(std::time::Duration::from_millis(20)),
        }
    }
}

/// A watchdog process on duty. Dropped without being dismissed, it switches the torque off; the port must be closed by
/// then.
#[derive(Debug)]
struct Watchdog {
    process: Child,
}

impl Watchdog {
    /// Puts one on duty for a run on this rig, and waits until it is.
    fn start(rig_file: &Path, context: &Context) -> anyhow::Result<Self> {
        let Some((program, arguments)) = context.watchdog.as_deref().and_then(<[_]>::split_first) else {
            anyhow::bail!("servos on a port move only with a watchdog process, and none was named");
        };
        let mut command = Command::new(program);
        command.args(arguments).arg(rig_file).stdin(Stdio::piped()).stdout(Stdio::piped());
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(&mut command, 0);
        let mut process = command.spawn().context("starting the watchdog process")?;
        let ready = process.stdout.take().map(|mut words| words.read_exact(&mut [0]));
        let watchdog = Self { process };
        match ready {
            Some(Ok(())) => Ok(watchdog),
            _ => Err(anyhow::anyhow!("the watchdog process did not start")),
        }
    }

    /// Sends it home: the run has dealt with the torque.
    fn dismiss(mut self) {
        if let Some(pipe) = &mut self.process.stdin {
            // If it has ended already, there is nothing to do.
            let _ = pipe.write_all(&[ALL_IS_WELL]);
        }
    }
}

impl Drop for Watchdog {
    fn drop(&mut self) {
        self.process.stdin = None;
        let _ = self.process.wait();
    }
}

/// A rig, or two arms, on their ports with a watchdog process. Dropped, by an error or a panic, the ports are closed
/// first, and then the watchdog process switches the torque off.
pub struct WatchdogGuard<R> {
    // In this order: the watchdog process needs the port.
    rig: R,
    watchdog: Watchdog,
}

impl<R> WatchdogGuard<R> {
    /// Starts a watchdog process for the rig that `file` describes and waits until it is ready, before anything moves.
    pub fn new(rig: R, file: &Path, context: &Context) -> anyhow::Result<Self> {
        Ok(Self { rig, watchdog: Watchdog::start(file, context)? })
    }

    /// Closes the ports and sends the watchdog process home: the torque is as it shall be.
    pub fn close(self) {
        let Self { rig, watchdog } = self;
        drop(rig);
        watchdog.dismiss();
    }
}

impl<R> Deref for WatchdogGuard<R> {
    type Target = R;

    fn deref(&self) -> &R {
        &self.rig
    }
}

impl<R> DerefMut for WatchdogGuard<R> {
    fn deref_mut(&mut self) -> &mut R {
        &mut self.rig
    }
}
