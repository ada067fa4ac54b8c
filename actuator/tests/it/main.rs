//! Facts about tendons and servos.
#![allow(clippy::unwrap_used, clippy::print_stderr)] // a test may stop where it stands

mod fuzz;
mod golden;
mod identify;
mod pulley;
mod servo;
mod tendon;
