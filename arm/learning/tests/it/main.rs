//! Learned dynamics on simulated and recorded motions.

#![allow(clippy::unwrap_used)] // a test may stop where it stands

mod identified;
mod learned;
mod learned_body;
mod measured_servo;
