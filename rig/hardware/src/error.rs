//! Errors of a rig.

use crate::bus::{ServoTorque, describe_torques};
use hysteron_base::BadInput;

/// Errors of `rig`.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A file or an option is wrong.
    #[error(transparent)]
    BadInput(#[from] BadInput),
    /// A file could not be read or written.
    #[error(transparent)]
    File(#[from] hysteron_base::Error),
    /// The servos do not answer as they should.
    #[error("servo bus: {0}")]
    Bus(String),
    /// Not all servos have confirmed that their torque is off: the state of each.
    #[error("servo bus: the torque is not known to be off: {}", describe_torques(.0))]
    Torque(Vec<ServoTorque>),
    /// The tracker does not answer as it should.
    #[error("tracker: {0}")]
    Tracker(String),
    /// The recording cannot be written.
    #[error("writing the recording: {0} (hint: free space on the disk; the recorded rows are kept)")]
    Disk(std::io::Error),
    /// A limit was passed, and the run was ended safely.
    #[error("limit: {0}")]
    Limit(String),
    /// Interrupted by the user; the text names the step that was not done.
    #[error("interrupted before {0}")]
    Interrupted(&'static str),
}

/// Result of a function in `rig`.
pub type Result<T> = std::result::Result<T, Error>;

impl Error {
    /// Reason alone, for a message that already names the bus.
    pub(crate) fn reason(self) -> String {
        match self {
            Self::Bus(why) => why,
            Self::Torque(servos) => describe_torques(&servos),
            other => other.to_string(),
        }
    }

    /// The bad input behind this error, if that is what it is.
    pub fn bad_input(&self) -> Option<&BadInput> {
        match self {
            Self::BadInput(bad) | Self::File(hysteron_base::Error::BadInput(bad)) => Some(bad),
            _ => None,
        }
    }
}
