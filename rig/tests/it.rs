//! The rig against its emulated counterparts.
#![allow(clippy::unwrap_used)] // a test may stop where it stands

#[path = "it/tracker.rs"]
mod tracker;
