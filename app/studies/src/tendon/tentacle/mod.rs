//! `study tentacle`: fourteen holds of a silicone tentacle under known tension, with nominal parameters, with fitted ones, and
//! with residual tensions on top.
//!
//! Frames: the mesh has the body along z; mocap x, y, z are the mesh's y, z, x. The robot hangs, gravity
//! along the body. Markers sit on arms fixed to the sections, whose rotation is the best fit over points of the
//! section.

mod fits;
mod holds;
mod outcome;
mod page;
mod residual;
mod run;
mod setup;

pub use outcome::{
    FittedValue, HoldErrors, ParameterFit, PooledError, ResidualTensions, SharedTensions, TentacleMetrics,
};
pub use run::run;
