//! Reports of verbs that have no `page.rs` yet.

pub mod commands;
pub mod coverage;
pub mod target;
pub mod tracking;
