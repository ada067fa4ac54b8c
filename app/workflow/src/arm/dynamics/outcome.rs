//! The outcome of `arm dynamics`.

use std::path::PathBuf;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::shared::outcome;

/// The outcome of `arm dynamics`.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Outcome {
    /// Number of samples.
    pub rows: usize,
    /// The recording of the results.
    pub out: PathBuf,
    /// Joints that `--fix-base` holds at zero.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub held_joints: Vec<String>,
}

impl outcome::Outcome for Outcome {}
