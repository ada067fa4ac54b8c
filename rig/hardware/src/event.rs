//! Events of a run, one line each: the log next to every recording.

use serde::{Deserialize, Serialize};

/// One thing that happened.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Event {
    /// When, on the rig's clock [s].
    pub time_s: f64,
    /// Kind of the event.
    pub kind: EventKind,
    /// Servo it concerns, by its id on the bus.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub servo: Option<u8>,
    /// For a person.
    pub message: String,
}

/// Kinds of events.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum EventKind {
    /// A servo gave no answer in time.
    Timeout,
    /// An answer was damaged: checksum, header, length, or from another servo.
    Corrupt,
    /// A servo refused an instruction with an error number.
    Refused,
    /// A servo reports a hardware error: overload, heat, voltage.
    HardwareError,
    /// A servo lost its settings: its supply broke down and came back.
    Reset,
    /// A servo does not answer any more.
    ServoLost,
    /// The serial port is gone, or back.
    BusLost,
    /// The port is back.
    BusBack,
    /// The connection to the tracker is gone.
    TrackerLost,
    /// The connection to the tracker is back.
    TrackerBack,
    /// No new pose for longer than the tracker's rate explains.
    TrackerStale,
    /// A pose that cannot be trusted.
    TrackerQuality,
    /// A message of the tracker was damaged.
    TrackerCorrupt,
    /// A tendon near the load limit is pulled no further, or again.
    Hold,
    /// A contact was detected from the measurements, or has ended.
    Contact,
    /// A limit was passed.
    Limit,
    /// A cycle came too late.
    Late,
    /// The run began, was asked to stop, ended; torque went on or off.
    Run,
}
