//! The tracker: 6-DOF poses over OpenIGTLink, from a cable or a recording, on the host's clock and in the robot's
//! frame.
//!
//! In the order of the data: bytes ([`MessageDecoder`]) become messages ([`Message`]); the [`Client`] picks one tool,
//! places its poses in time ([`ClockMap`]) and evaluates them ([`Monitor`]); a [`Registration`] turns them into the
//! robot's frame.

mod client;
mod clock;
mod crc;
mod damage;
mod decoder;
mod fields;
mod message;
mod pose_queue;
mod quality;
mod registration;
mod repeats;
mod replay;
mod survey;

pub use client::{Client, TrackerSettings};
pub use clock::{ClockMap, GATE, MAX_DRIFT, WINDOW};
pub use decoder::{DecodedMessage, MAX_BUFFERED, MessageDecoder};
pub use message::{Message, MessageContent, MessageFormat, ToolPose, Validity, start_request};
pub use pose_queue::PoseCounts;
pub use quality::{Monitor, PoseLimits};
pub use registration::{PulledMotion, Registration};
pub use replay::Replay;
pub use survey::TrackerSurvey;
