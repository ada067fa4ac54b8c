//! The servo bus: Dynamixel protocol 2.0.

pub mod xl430;
