//! The numbers of `study population`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::tendon::path_following::FollowedMethod;

/// The numbers of `study population`.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct PopulationMetrics {
    /// One for each robot.
    pub robots: Vec<PopulationRobot>,
}

/// A robot along every path, or why there is nothing.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct PopulationRobot {
    /// The robot.
    pub robot: String,
    /// One for each path.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub paths: Option<Vec<PopulationPath>>,
    /// Why a stage failed on it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub failed: Option<String>,
}

/// A path by every method.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct PopulationPath {
    /// The path.
    pub target: String,
    /// One for each method.
    pub methods: Vec<FollowedMethod>,
}
