//! The bodies, friction and rotors of an arm from its motion and torques, by linear regression with bodies that can exist.

mod bodies;
mod evolution;
mod motion;
mod normal;
mod payload;
mod pseudo_inertia;
mod response;

pub use bodies::{BodyFit, BodyOptions, Determined, TermEstimate, identify_bodies};
pub use evolution::{EvolutionFit, evolve_bodies};
pub use motion::{JointMotion, Smoothing};
pub use normal::JointTerm;
pub use payload::{PayloadFit, identify_payload};
pub use pseudo_inertia::pseudo_inertia;
pub use response::TorqueResponse;
