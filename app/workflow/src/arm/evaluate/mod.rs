//! `hysteron arm evaluate`: a learned model, of inverse dynamics or of actuators, next to recordings.

mod actuator;
mod inverse_dynamics;
mod options;
mod outcome;
mod page;
mod run;

pub use options::Options;
pub use outcome::{ActuatorEvaluation, DynamicsScores, Outcome};
pub use run::run;
