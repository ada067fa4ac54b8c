//! Ctrl-C and SIGTERM: the first asks the verb to stop, which it does at its next good moment; a second ends the program.
//!
//! A verb that does not come to a good moment soon is ended. Nothing is lost by that: files are renamed into place when
//! they are whole, and what is half written, and the locks, are removed first. A verb that drives a rig is given the time to
//! switch its torque off.

use std::sync::atomic::{AtomicU8, AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use hysteron_base::abandon_outputs;

use crate::terminal;

/// A verb that was asked to stop has this long: with the time to remove files and to end, less than two seconds.
const PATIENCE: Duration = Duration::from_millis(1200);
/// An asked verb is looked after so often.
const LOOK_EVERY: Duration = Duration::from_millis(20);

/// Effect of a first request to end.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Manner {
    /// Ends the program: the verb has not begun its work.
    AtOnce,
    /// Ends the program if the verb has not ended by then.
    Soon,
    /// Waits for the verb, which drives a rig.
    WithRig,
    /// Waits for the programs that this one has started, and to which it passes all requests on.
    WithOthers,
}

static MANNER: AtomicU8 = AtomicU8::new(Manner::AtOnce as u8);
static TIMES_ASKED: AtomicUsize = AtomicUsize::new(0);

impl Manner {
    fn now() -> Self {
        let all = [Self::AtOnce, Self::Soon, Self::WithRig, Self::WithOthers];
        let now = MANNER.load(Ordering::Relaxed);
        all.into_iter().find(|manner| *manner as u8 == now).unwrap_or(Self::AtOnce)
    }

    fn begin(self) {
        MANNER.store(self as u8, Ordering::Relaxed);
    }
}

/// Listens for both from here on.
///
/// # Errors
/// If the system refuses.
pub fn start() -> anyhow::Result<()> {
    ctrlc::set_handler(|| {
        let is_first = TIMES_ASKED.fetch_add(1, Ordering::Relaxed) == 0;
        match Manner::now() {
            Manner::WithOthers => {}
            _ if is_first => drop(std::thread::spawn(look_after)),
            _ => end("interrupted twice"),
        }
    })?;
    Ok(())
}

/// From here on requests are passed to the verb by [`is_requested`].
pub fn listen() {
    Manner::Soon.begin();
}

/// As [`listen`], of a verb that drives a rig from here on.
pub fn listen_on_rig() {
    Manner::WithRig.begin();
}

/// Only counts requests from here on: the program passes them on, and ends when those have ended that it started.
pub fn count() {
    Manner::WithOthers.begin();
}

/// True once the person has asked to stop.
pub fn is_requested() -> bool {
    n_requests() > 0
}

/// How often the person has asked to stop.
pub fn n_requests() -> usize {
    TIMES_ASKED.load(Ordering::Relaxed)
}

/// Ends the program when the verb has had its time.
fn look_after() {
    let mut since = Instant::now();
    loop {
        match Manner::now() {
            Manner::AtOnce => end("interrupted; nothing was begun"),
            Manner::Soon if since.elapsed() >= PATIENCE => {
                end("interrupted; finished results are kept, the same command starts the rest again")
            }
            Manner::Soon => {}
            Manner::WithRig | Manner::WithOthers => since = Instant::now(),
        }
        std::thread::sleep(LOOK_EVERY);
    }
}

/// Ends the program, without a part of a file or a lock left behind.
fn end(why: &str) -> ! {
    abandon_outputs();
    terminal::report_error(&anyhow::anyhow!("{why}"));
    std::process::exit(1)
}
