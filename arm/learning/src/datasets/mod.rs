//! Public recordings of arms as samples: where each keeps its numbers, and what it lacks.
//!
//! None of them is part of the project. Accelerations that were not recorded are central differences of low-passed
//! velocities.

mod filter;
mod sets;
mod table;

pub(crate) use filter::check_rate;
pub use filter::{differentiate, low_pass};
pub use sets::{BaxterTraining, RealSet, baxter, characters, kuka, kuka_arm, panda};

/// Kinematics of Baxter's arm, as URDF.
pub const BAXTER_ARM: &str = include_str!("../../robots/baxter_arm.urdf");
