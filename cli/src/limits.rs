//! Limits that a system sets for a process: what goes beyond becomes an error with a message.

#[cfg(unix)]
use std::sync::{Arc, atomic::AtomicBool};

/// Writing beyond the largest file that is allowed (`ulimit -f`) fails from here on, as on a full disk; without this the
/// signal SIGXFSZ ends the program where it is.
///
/// # Errors
/// If the system refuses.
#[cfg(unix)]
pub fn outlive_file_sizes() -> anyhow::Result<()> {
    // Linux, macOS and the BSDs have one number for it.
    const SIGXFSZ: i32 = rustix::process::Signal::XFSZ.as_raw();
    // Nobody asks whether it came: the write that it is about has failed.
    signal_hook::flag::register(SIGXFSZ, Arc::new(AtomicBool::new(false)))?;
    Ok(())
}

/// As on systems without such a limit.
#[cfg(not(unix))]
pub fn outlive_file_sizes() -> anyhow::Result<()> {
    Ok(())
}
