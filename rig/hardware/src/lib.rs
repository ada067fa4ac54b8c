//! Servos, tracker, calibration, recording and safety of a tendon-driven rig.
//!
//! Never imports the twin: both speak [`hysteron_base::Recording`].

pub mod bus;
pub mod calibration;
pub mod config;
mod error;
mod event;
mod hardware;
mod live;
mod pose;
mod safety;
pub mod session;
pub mod teleoperation;
pub mod tracker;

pub use error::{Error, Result};
pub use event::{Event, EventKind};
pub use hardware::{Hardware, ServoSample, SlowSample};
pub use live::LiveRig;
pub use pose::{Pose, Quality};
pub use safety::{ShutdownAction, Violation};
