//! `study identification`: friction and bodies by every method. Recorded friction of a Franka arm compared with eight
//! published models, friction of the SCARA of Wan et al. (2026), bodies of the wrist of Saadatzi et al. (2019).

mod cells;
mod franka;
mod options;
mod outcome;
mod page;
mod run;
mod sweep;

pub use cells::{IdentificationOptions, IdentificationStudy, identification_study};
pub use franka::{FrankaCell, FrankaRow, PUBLISHED, SPEEDS, TARE, franka_cell};
pub use options::Options;
pub use outcome::Outcome;
pub use run::run;
pub use sweep::{JOINT_2, SweepCell, SweepRow, sweep_cell};
