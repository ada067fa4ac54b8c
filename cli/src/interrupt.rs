//! Ctrl-C: the first one asks the run to stop after the present sample, the second ends the program.
//!
//! Files are renamed into place when they are whole, so even the second leaves no part of one.

use std::sync::atomic::{AtomicBool, Ordering};

static ASKED: AtomicBool = AtomicBool::new(false);
static IS_LISTENING: AtomicBool = AtomicBool::new(false);

/// Starts listening for Ctrl-C and for a polite request to end (SIGTERM); once, however often it is called.
pub fn listen() -> anyhow::Result<()> {
    if IS_LISTENING.swap(true, Ordering::Relaxed) {
        return Ok(());
    }
    ctrlc::set_handler(|| {
        if ASKED.swap(true, Ordering::Relaxed) {
            std::process::exit(1);
        }
    })?;
    Ok(())
}

/// True once the person has asked to stop.
pub fn is_asked() -> bool {
    ASKED.load(Ordering::Relaxed)
}
