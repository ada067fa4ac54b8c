//! Following a recording while it is made.

use crate::{EventKind, Violation};

/// Follows the rows of a recording, and may end it.
pub trait Supervisor: std::fmt::Debug {
    /// Takes the next row as the recording will have it, as soon as its pose is known: time since the first row [s], values in the
    /// order of [`channels`](super::Recorder::channels), NaN where nothing was measured. It must not wait in real time.
    fn take_row(&mut self, time: f64, row: &[f64]);

    /// Asked after every cycle; appends to `notes` what belongs in the log.
    ///
    /// # Errors
    /// The reason to end the recording.
    fn check(&mut self, notes: &mut Vec<(EventKind, String)>) -> Result<(), Violation>;
}
