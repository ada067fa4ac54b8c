//! The numbers of `study sensing`.

use hysteron_twin::sense::ForceSensor;
use hysteron_twin::sense::SensingScores;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The numbers of `study sensing`.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct SensingMetrics {
    /// One for each robot.
    pub robots: Vec<SensedRobot>,
}

/// The sensor of one robot.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct SensedRobot {
    /// The robot.
    pub robot: String,
    /// Scores of tensions and pushes, as `sense` gives them.
    pub scores: SensingScores,
    /// The sensor, as `sense` gives it.
    pub sensor: ForceSensor,
    /// False alarms in recordings without contact.
    pub without_contact: WithoutContact,
}

/// False alarms in recordings without contact.
#[derive(Debug, Clone, Copy, Serialize, Deserialize, JsonSchema)]
pub struct WithoutContact {
    /// Number of alarms.
    pub alarms: f64,
    /// Time without contact [s].
    pub seconds: f64,
}
