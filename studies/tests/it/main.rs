//! Studies of arms: quick forms of them, and what published recordings say.

#![allow(clippy::unwrap_used)] // a test may stop where it stands

mod identification;
mod learned;
