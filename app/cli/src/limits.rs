//! Limits that a system sets for a process: what goes beyond becomes an error with a message.

#[cfg(unix)]
use std::sync::{Arc, atomic::AtomicBool};

use hysteron_base::BadInput;
use hysteron_base::size::address_space;

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

/// Address space that a verb has to find free [byte]: what the smallest of them, its threads and their stacks take.
const MIN_ADDRESS_SPACE: u64 = 64 << 20;

/// Refuses to begin where the address space is limited (`ulimit -v`) so far that memory would be refused in the middle of
/// the work, which ends a program on the spot. Where more is asked for than is left, each verb reports it
/// itself.
///
/// # Errors
/// `BadInput` naming what is left.
pub fn check_address_space() -> Result<(), BadInput> {
    let megabytes = |bytes: u64| format!("{} MB", bytes >> 20);
    match address_space() {
        Some(free) if free < MIN_ADDRESS_SPACE => {
            let expected = format!("at least {} of address space left", megabytes(MIN_ADDRESS_SPACE));
            Err(BadInput::new("memory", expected, megabytes(free))
                .hint("raise the limit: ulimit -v unlimited"))
        }
        _ => Ok(()),
    }
}
