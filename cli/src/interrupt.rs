//! Ctrl-C: the first one asks the run to stop after the present sample, the second ends the program.
//!
//! Files are renamed into place when they are whole, so even the second leaves no part of one.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

static TIMES_ASKED: AtomicUsize = AtomicUsize::new(0);
static IS_LISTENING: AtomicBool = AtomicBool::new(false);

/// Starts listening for Ctrl-C and for a polite request to end (SIGTERM); once, however often it is called.
pub fn listen() -> anyhow::Result<()> {
    if IS_LISTENING.swap(true, Ordering::Relaxed) {
        return Ok(());
    }
    ctrlc::set_handler(|| {
        if TIMES_ASKED.fetch_add(1, Ordering::Relaxed) > 0 {
            std::process::exit(1);
        }
    })?;
    Ok(())
}

/// As [`listen`], but the program only counts: it passes them on, and ends when those have ended that it started.
pub fn count() -> anyhow::Result<()> {
    ctrlc::set_handler(|| {
        TIMES_ASKED.fetch_add(1, Ordering::Relaxed);
    })?;
    Ok(())
}

/// True once the person has asked to stop.
pub fn is_asked() -> bool {
    times_asked() > 0
}

/// How often the person has asked to stop.
pub fn times_asked() -> usize {
    TIMES_ASKED.load(Ordering::Relaxed)
}
