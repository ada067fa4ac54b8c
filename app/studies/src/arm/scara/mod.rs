//! `study scara`: friction, external torques and collisions of the simulated SCARA of Wan et al. (2026).

mod cells;
mod options;
mod outcome;
mod page;
mod run;

pub use cells::{ScaraOptions, ScaraStudy, scara_study};
pub use options::Options;
pub use outcome::Outcome;
pub use run::run;
