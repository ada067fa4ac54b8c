//! Studies of arms: quick forms of them, and results on published recordings.

#![allow(clippy::unwrap_used)] // a test may stop where it stands

mod identification;
mod learned;
