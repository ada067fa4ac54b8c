//! `study layouts`: layouts of auxiliary tendons, the paper's 36 compared with fewer, longer ones.
//!
//! The singular values of ∂tip/∂s* show in which directions a layout moves the tip, and how evenly; the
//! identification, and a network trained on it on the tests of `coreact`, measure the benefit.

mod outcome;
mod page;
mod run;

pub use outcome::{LayoutMetrics, LayoutReach};
pub use run::run;
