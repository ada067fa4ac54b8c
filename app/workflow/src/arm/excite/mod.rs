//! `hysteron arm excite`: motions that make parameters visible.

mod options;
mod outcome;
mod page;
mod run;

pub use options::{Options, Shape};
pub use outcome::Outcome;
pub use run::run;
