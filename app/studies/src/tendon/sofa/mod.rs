//! `study sofa`: the same tube and cables as SOFA, tip and tension, stroke by stroke.

mod curve;
mod outcome;
mod page;
mod run;

pub use curve::{Curve, Difference, compare, solve};
pub use outcome::Comparison;
pub use run::run;
