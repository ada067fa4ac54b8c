//! `hysteron arm`: rigid-body arms. A room for each verb, and what several of them share.

pub mod adapt;
pub mod dynamics;
#[cfg(unix)]
pub mod emulate;
pub mod estimate;
pub mod evaluate;
pub mod excite;
pub mod export;
pub mod fit;
pub mod generate;
pub mod identify;
pub mod info;
mod motion_charts;
pub mod record;
pub mod recordings;
mod robot;
pub mod simulate;
mod virtual_arm;

pub use recordings::meta;
pub use robot::{RobotOptions, drive, file_of, reads, refuse_robot};
