//! `hysteron mesh`: a round body with bore, channels and taper, straight from its measures.

mod measures;
mod options;
mod outcome;
mod quality;
mod run;

pub use options::Options;
pub use outcome::{MeshSummary, Outcome, Spread};
pub use quality::print_quality;
pub use run::run;
