//! Studies of estimated external torques: the wrist of Saadatzi et al. (2019) and the SCARA of Wan et al. (2026), simulated.
//!
//! The simulated arm (`plant`) shares neither code nor parameters with the estimators: these identify themselves from what
//! encoders and drives measure.

pub mod collisions;
mod known;
pub(crate) mod page;
mod plant;
pub mod scara;
pub mod scara_friction;
pub mod scara_signals;
pub mod simulated_errors;
pub mod wrist;
pub mod wrist_sweep;

pub use known::{KnownArm, TERMS};

/// Standard normal numbers of a stream.
fn normal(seed: u64, stream: &str) -> impl FnMut() -> f64 + use<> {
    let mut random = hysteron_base::rng(seed, stream);
    move || hysteron_base::normal(&mut random)
}
