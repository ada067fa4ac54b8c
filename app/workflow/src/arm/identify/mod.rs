//! `hysteron arm identify`: bodies, friction, drives and payloads of arms from recordings of them.

pub mod friction;
pub mod inertia;
mod motion;
pub mod payload;
mod recordings;
pub mod servo;

pub use motion::MotionOptions;
