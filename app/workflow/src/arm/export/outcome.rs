//! The outcome of `arm export`.

use std::path::PathBuf;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::shared::outcome;

/// The outcome of `arm export`.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Outcome {
    /// Number of joints that move.
    pub joints: usize,
    /// The file.
    pub out: PathBuf,
    /// Joints that `--fix-base` holds at zero.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub held_joints: Vec<String>,
}

impl outcome::Outcome for Outcome {}
