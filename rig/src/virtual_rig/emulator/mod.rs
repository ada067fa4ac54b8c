//! The virtual rig behind the ports of a real one.

mod pose_server;

pub use pose_server::{Delivery, DeviceClock, Format, PoseServer, PoseServerSettings};
