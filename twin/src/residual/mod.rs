//! The residual network g (paper 003, eqs. 9-11): it learns the auxiliary strokes of CoReAct from what was commanded,
//! so that the twin shows the robot's hysteresis by itself.
//!
//! Two designs. [`Design::Windowed`] is the paper's: a window of strokes and tips in, all auxiliary strokes out, fitted
//! to s*. [`Design::Stateful`] goes through whole trajectories with one cell update a sample. It sees the strokes
//! through the operators that hysteresis is made of, play and relaxation, gives the tip displacement that is missing
//! (three numbers, spread over the tendons by a fixed map), and is fitted to the measured tip through the linearised
//! twin, ∂y/∂s of the identification.

mod adaptation;
mod decoder;
mod features;
mod follower;
mod model;
mod rollout;
mod sequence;
mod stateful;
mod windowed;

pub use adaptation::{AdaptOptions, Adaptation};
pub use decoder::Decoder;
pub use features::{FeatureSpec, Features};
pub use follower::{Coordinates, FollowLimits, FollowStep, Follower};
pub use model::{Design, ResidualModel};
pub use rollout::Rollout;
pub use sequence::Sequence;
pub use stateful::{StatefulOptions, fit_stateful};
pub use windowed::{WindowedOptions, fit_windowed};

/// What a training reports after an epoch, and what it asks.
pub struct Epoch {
    /// Which network of several, from 0.
    pub member: usize,
    /// Epochs done, from 1.
    pub number: usize,
    /// Root mean square error on the training sequences [mm], as the design measures it.
    pub training_mm: f64,
    /// The same on the held-out ones.
    pub held_out_mm: f64,
    /// The best of the held-out errors so far.
    pub best_mm: f64,
}
