//! `study run`: the whole chain from a recording to a tracked path, stage by stage, defined by a study file.
//!
//! A stage is this program, started again with the arguments that a person would type. Its inputs are
//! in its stamp, so that a stage is done once, and again only when something that it reads has changed.

mod convert;
mod definition;
#[cfg(test)]
mod fuzz;
mod method;
mod options;
mod outcome;
mod page;
mod run;
mod schema;
mod stage;
mod stages;
mod stamp;
mod text;

pub use definition::{PlanChoice, Rig, SceneChoice, Study, Target, Track};
pub use method::Method;
pub use options::Options;
pub use outcome::Outcome;
pub use run::run;
pub use stage::{OnRefusal, Stage, Step};
pub use stamp::{StageStatus, Stamp, clear_outputs};
