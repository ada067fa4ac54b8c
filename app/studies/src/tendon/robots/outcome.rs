//! The numbers of `study robots`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::tendon::coreact::TwinTable;

/// The numbers of `study robots`.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct RobotsMetrics {
    /// Twins of the ablation of every preset, and those of `typical` on the population around it.
    pub ladders: Vec<TwinTable>,
}
