//! `hysteron identify-servo`: friction, backlash and load scale of a rig's servos from recordings of it.

mod found;
mod options;
mod outcome;
mod page;
mod run;
mod servos;

pub use options::Options;
pub use outcome::{Outcome, ServoEstimates};
pub use run::run;
