//! The pseudo-terminal in place of the serial adapter, under a name that outlives it.
//!
//! The name is a symbolic link. Unplugging drops the pseudo-terminal and the link, as udev does; plugging makes both
//! anew. The emulator keeps a handle on the device's side too, so that a host may close and open it at will.

use std::io::{ErrorKind, Read, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use hysteron_base::BadInput;
use hysteron_rig::{Error, Result};
use serialport::{ClearBuffer, SerialPort, TTYPort};

/// A sleep ends this much late at most, mostly; the rest is waited out awake.
const SLEEP_SLACK: Duration = Duration::from_micros(80);
/// Longest wait for room in the buffer of a host that does not read.
const FULL_BUFFER: Duration = Duration::from_millis(1);

/// How exactly answers keep the times of the wire.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Timing {
    /// To some microseconds: the last of each wait is spent awake.
    Wire,
    /// Some 0.1 ms late: every wait is slept through. For machines with other work to do.
    Relaxed,
}

impl Timing {
    /// Returns at that time, or at once if it is past.
    pub(super) fn wait_until(self, time: Instant) {
        let slack = match self {
            Self::Wire => SLEEP_SLACK,
            Self::Relaxed => Duration::ZERO,
        };
        let left = time.saturating_duration_since(Instant::now());
        if left > slack {
            std::thread::sleep(left - slack);
        }
        while Instant::now() < time {
            std::hint::spin_loop();
        }
    }
}

/// The serial adapter of the emulated bus.
#[derive(Debug)]
pub(super) struct EmulatedPort {
    link: PathBuf,
    pair: Option<PortPair>,
}

#[derive(Debug)]
struct PortPair {
    emulator: TTYPort,
    host: TTYPort,
}

impl EmulatedPort {
    /// Plugged in under this name.
    ///
    /// # Errors
    /// `BadInput` if something else than a link has the name, `Bus` if the system gives no pseudo-terminal.
    pub fn open(link: &Path) -> Result<Self> {
        if std::fs::symlink_metadata(link).is_ok_and(|at| !at.file_type().is_symlink()) {
            return Err(BadInput::new(link.display().to_string(), "a free name for the port", "a file")
                .hint("move it away, or name another folder")
                .into());
        }
        let mut port = Self { link: link.to_owned(), pair: None };
        port.plug()?;
        Ok(port)
    }

    /// Name of the device, as a host opens it.
    pub fn link(&self) -> &Path {
        &self.link
    }

    /// Whether there is a device.
    pub fn is_plugged(&self) -> bool {
        self.pair.is_some()
    }

    /// Makes a new device under the name.
    ///
    /// # Errors
    /// `Bus` if the system refuses.
    pub fn plug(&mut self) -> Result<()> {
        let refused = |error: &dyn std::fmt::Display| Error::Bus(format!("{}: {error}", self.link.display()));
        let (mut emulator, host) = TTYPort::pair().map_err(|error| refused(&error))?;
        emulator.set_timeout(FULL_BUFFER).map_err(|error| refused(&error))?;
        let device = host.name().ok_or_else(|| refused(&"a pseudo-terminal without a name"))?;
        // In one step, so that the name always exists while it is replaced.
        let mut new = self.link.clone().into_os_string();
        new.push(".new");
        let _ = std::fs::remove_file(&new);
        std::os::unix::fs::symlink(device, &new).map_err(|error| refused(&error))?;
        std::fs::rename(&new, &self.link).map_err(|error| refused(&error))?;
        self.pair = Some(PortPair { emulator, host });
        Ok(())
    }

    /// Takes device and name away.
    pub fn unplug(&mut self) {
        let Some(pair) = self.pair.take() else { return };
        // Another emulator may have taken the name over.
        let is_ours = std::fs::read_link(&self.link).ok() == pair.host.name().map(PathBuf::from);
        if is_ours {
            let _ = std::fs::remove_file(&self.link);
        }
    }

    /// Baud that the host has set; `None` where it cannot be known.
    pub fn host_baud(&self) -> Option<u32> {
        // Elsewhere the handle only knows what it set itself.
        if !cfg!(target_os = "linux") {
            return None;
        }
        self.pair.as_ref()?.host.baud_rate().ok()
    }

    /// Reads what the host sent, waiting this long at most; 0 bytes if nothing came.
    pub fn read(&mut self, buffer: &mut [u8], wait: Duration) -> usize {
        let Some(pair) = &mut self.pair else {
            std::thread::sleep(wait);
            return 0;
        };
        let _ = pair.emulator.set_timeout(wait);
        match pair.emulator.read(buffer) {
            Ok(n) => n,
            Err(error) => {
                if !matches!(error.kind(), ErrorKind::TimedOut | ErrorKind::Interrupted) {
                    std::thread::sleep(wait);
                }
                0
            }
        }
    }

    /// Sends to the host. One that does not read loses what it was sent before.
    pub fn send(&mut self, bytes: &[u8]) {
        let Some(pair) = &mut self.pair else { return };
        let _ = pair.emulator.set_timeout(FULL_BUFFER);
        if pair.emulator.write_all(bytes).is_err() {
            let _ = pair.host.clear(ClearBuffer::Input);
        }
    }
}

impl Drop for EmulatedPort {
    fn drop(&mut self) {
        self.unplug();
    }
}
