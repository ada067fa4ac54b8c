//! How strokes are found for a path.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How strokes are found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Method {
    /// Through the twin of the scene without what is fitted to a robot, and without a network.
    Nominal,
    /// Through the twin of the scene itself, without a network.
    Scene,
    /// Through the calibrated twin with its network.
    Twin,
    /// By the inverse network.
    Network,
}

impl Method {
    /// As in a study file.
    pub fn name(self) -> &'static str {
        match self {
            Self::Nominal => "nominal",
            Self::Scene => "scene",
            Self::Twin => "twin",
            Self::Network => "network",
        }
    }
}
