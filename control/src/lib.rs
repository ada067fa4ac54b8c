//! Command plans: what to command a robot with tendons, in tendon space; the shape of the robot's response;
//! the inverse controller that follows a path of the tip; and how close a prediction comes.
//! Knows files, never the simulator.
//!
//! ```
//! use hysteron_control::TargetPath;
//!
//! let circle = TargetPath::open("circle:30")?.recording()?;
//! let x = circle.require("tip_x_m")?;
//! assert!(x.iter().all(|x| x.abs() < 15.1e-3));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

// Units are in brackets in the comments, [m] and [N], which rustdoc takes for links.
#![allow(rustdoc::broken_intra_doc_links)]

mod error;
pub mod inverse;
pub mod path;
pub mod plan;
pub mod repetition;
pub mod score;
pub mod shape;
pub mod split;
pub mod tracking;

pub use error::{Error, Result};
pub use path::TargetPath;
pub use plan::{LazyPlan, MotionPlan, StrokeLimits, Trajectory};
