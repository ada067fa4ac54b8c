//! The virtual rig behind the ports of a real one.

mod pose_delivery;
mod pose_server;

pub use pose_delivery::PoseDelivery;
pub use pose_server::{DeviceClock, Format, PoseFaults, PoseServer, PoseServerSettings};
