//! Quasi-static twin of a tendon-driven robot.
//!
//! ```
//! use std::path::Path;
//!
//! use hysteron_base::Scene;
//! use hysteron_twin::{Stepper, Target, Twin};
//!
//! let scene = Scene::read(Path::new("../meshes/tpu80/scene.toml"))?;
//! let twin = Twin::from_scene(&scene)?;
//! let mut stepper = Stepper::new(&twin);
//! let mut targets = vec![Target::Stroke(0.0); twin.tendons.len()];
//! for step in 1..=10 {
//!     // The first tendon is pulled, tenth of a millimetre by tenth, and the one across lets it.
//!     targets[0] = Target::Stroke(1e-4 * f64::from(step));
//!     targets[2] = Target::Stroke(-1e-4 * f64::from(step));
//!     let report = stepper.step(&twin, &targets)?;
//!     assert!(report.relative_residual < 1e-3);
//! }
//! let (tip, rest) = (twin.tip_of(stepper.state()), twin.tip_of(&twin.rest()));
//! assert!((tip[0] - rest[0]).hypot(tip[1] - rest[1]) > 1e-3);
//! # Ok::<(), hysteron_twin::Error>(())
//! ```

mod adjoint;
mod alignment;
mod anderson;
mod attachment;
mod body_shape;
mod cable;
pub mod chain;
pub mod command;
pub mod coreact;
mod equilibrium_residual;
mod error;
pub mod fit;
mod friction;
mod friction_points;
mod gmres;
mod inverse;
mod layout;
mod locking;
mod locking_estimate;
mod mesh_solver;
mod model;
mod motion;
mod newton;
mod plant;
mod predictor;
mod projection;
mod quasi_newton;
mod reachability;
mod registration;
mod report;
pub mod residual;
mod rollout;
pub mod sense;
mod solver;
mod state;
mod state_file;
mod stepper;
pub mod synthetic;
mod tensions;
mod tip;

pub use alignment::{alignment, nearest_rotation};
pub use cable::{CablePoint, Cables};
pub use error::{Cause, Error, Result};
pub use friction_points::{FrictionPoint, FrictionPoints};
pub use inverse::{ReachReport, TipGoal};
pub use layout::auxiliary_tendons;
pub use locking::{LockedMove, Locking};
pub use locking_estimate::{LockingComparison, LockingEstimate, LockingEstimator, RunLocking};
pub use model::{Couple, Target, Twin, TwinTendon, read_body};
pub use motion::RobotMotion;
pub use plant::{PhysicsTwin, Plant, PlantStep, relax_to_equilibrium};
pub use reachability::{CurveGoals, Goal, Reach};
pub use registration::Registration;
pub use report::{Accuracy, StepReport};
pub use rollout::{Rollout, rollout, rollouts};
pub use state::TwinState;
pub use stepper::Stepper;
pub use tip::TipResponse;

// Robots for unit tests; the integration tests use the same file.
#[cfg(test)]
#[path = "../tests/twin/scenes.rs"]
mod scenes;
