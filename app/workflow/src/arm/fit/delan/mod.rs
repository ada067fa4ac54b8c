//! `hysteron arm fit delan`: a learned model of inverse dynamics from recordings.

mod options;
mod outcome;
mod run;

pub use options::{Options, variant};
pub use outcome::Outcome;
pub use run::run;
