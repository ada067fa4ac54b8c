//! Force at the tip without a sensor, by the classical estimators of table VI of Dou et al. (NeuralActuator): `study force`.
//!
//! Everything that estimators need is identified on contact-free training trajectories of the same arm;
//! thresholds are fitted there too. Recordings are those of NAD or of the virtual arm, which shares no
//! code with the estimators, or NAD itself.

mod cells;
mod data;
mod methods;
mod options;
mod outcome;
mod page;
mod run;
mod score;

pub use cells::{ForceCell, ForceStudy, force_study};
pub use hysteron_arm_estimation::servo_force::ServoForceTelemetry;
pub use methods::{METHODS, PUBLISHED, TASKS};
pub use options::Options;
pub use outcome::Outcome;
pub use run::run;
pub use score::{FalseContacts, FreeRow, LoadedRow, Trace};

/// Rows of the arm's joints that a study reads of a set of recordings.
#[derive(Debug, Clone, Default)]
pub struct ForceData {
    /// Contact-free, to identify with.
    pub training: Vec<ServoForceTelemetry>,
    /// Contact-free, to count false contacts on; with their tasks.
    pub free: Vec<(String, ServoForceTelemetry)>,
    /// With objects; with their tasks.
    pub loaded: Vec<(String, ServoForceTelemetry)>,
}
