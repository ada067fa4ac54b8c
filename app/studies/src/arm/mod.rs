//! Studies of arms.

pub mod cloning;
pub mod estimation;
pub mod force;
pub mod identification;
pub mod learned;
pub mod neural;
pub mod scara;
pub mod wrist;
