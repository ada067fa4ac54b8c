//! The numbers of `study ablation`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::tendon::path_following::FollowedKeys;

/// The numbers of `study ablation`.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct AblationMetrics {
    /// One for each robot.
    pub robots: Vec<AblatedRobot>,
}

/// A robot along every path.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct AblatedRobot {
    /// The robot.
    pub robot: String,
    /// One for each path.
    pub paths: Vec<AblationPath>,
}

/// A path by every ablation level.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct AblationPath {
    /// The path.
    pub target: String,
    /// One for each level.
    pub rungs: Vec<LevelResult>,
}

/// An ablation level.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct LevelResult {
    /// Name of the level.
    #[serde(rename = "rung")]
    pub level: String,
    /// How closely the tip followed the target.
    #[serde(flatten)]
    pub followed: FollowedKeys,
}
