//! `study cloning`: behaviour cloning with and without a force among the inputs. An object of unknown mass is put in place, or
//! held in place.
//!
//! Demonstrations come from an expert that sees how far the arm is from its plan and leads the goals until it is there. A policy learns the
//! lead from what it observes at the same time. Rows differ in that alone. Trials are the same for every row.

mod options;
mod outcome;
mod page;
mod policy;
mod run;
mod score;
mod trial;

pub use options::Options;
pub use outcome::Outcome;
pub use run::run;
