//! Facts about tendons and servos.
#![allow(clippy::unwrap_used)] // a test may stop where it stands

mod servo;
mod tendon;
