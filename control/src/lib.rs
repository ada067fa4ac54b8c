//! Command plans: what to command a robot with tendons, in tendon space; and the shape that the robot makes of it.
//! Knows files, never the simulator.

// Units stand in brackets in the comments, [m] and [N], which rustdoc takes for links.
#![allow(rustdoc::broken_intra_doc_links)]

mod error;
pub mod plan;
pub mod shape;

pub use error::{Error, Result};
pub use plan::{Limits, Plan, Trajectory};
