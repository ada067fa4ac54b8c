//! Quasi-static twin of a tendon-driven robot.

mod adjoint;
mod alignment;
mod anderson;
mod balance;
mod cable;
pub mod coreact;
mod error;
pub mod fit;
mod friction;
mod gmres;
mod inverse;
mod layout;
mod model;
mod motion;
mod newton;
mod plant;
mod predictor;
mod projection;
pub mod qp;
mod quasi_newton;
pub mod residual;
mod rollout;
mod state;
mod step;
pub mod synthetic;
mod tensions;
mod tip;

pub use alignment::{alignment, nearest_rotation};
pub use cable::Cables;
pub use error::{Cause, Error, Result};
pub use friction::FrictionPoint;
pub use inverse::{ReachReport, TipGoal};
pub use layout::auxiliary_tendons;
pub use model::{Accuracy, Couple, Target, TendonSpec, Twin};
pub use motion::Motion;
pub use plant::{Plant, PlantStep, Uncorrected, settle};
pub use rollout::{Rollout, rollout, rollouts};
pub use state::TwinState;
pub use step::{StepReport, Stepper};
pub use tip::Registration;

// Robots for unit tests; the integration tests use the same file.
#[cfg(test)]
#[path = "../tests/twin/scenes.rs"]
mod scenes;
