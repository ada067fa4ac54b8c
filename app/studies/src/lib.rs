//! Studies: what papers print, measured again, and comparisons with other programs and recorded robots.
//!
//! A room for each study: its options, its cells or its run, its outcome and its page. [`runner`] holds what all share.

pub mod arm;
pub mod chain;
mod list;
pub mod outcomes;
pub mod runner;
pub mod tendon;

pub use list::{ArmStudy, TendonStudy};
