//! `hysteron arm identify servo`: motor, supply, heat and friction of a servo that swings a weight, by rollout.

mod options;
mod outcome;
mod page;
mod recordings;
mod run;

pub use options::Options;
pub use outcome::Outcome;
pub use run::run;
