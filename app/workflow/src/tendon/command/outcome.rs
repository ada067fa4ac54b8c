//! The outcome of `command`.

use std::path::PathBuf;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::shared::outcome::MetricsFormat;

/// The outcome of `command`.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Outcome {
    /// Format of the file.
    pub format: MetricsFormat,
    /// Its version.
    pub version: u32,
    /// The recording of the strokes.
    pub out: PathBuf,
    /// Samples of the path itself.
    pub samples: usize,
    /// Samples of the approach before it.
    pub approach_samples: usize,
    /// Samples of the return after it.
    pub return_samples: usize,
    /// Provenance of the strokes.
    pub source: String,
    /// Share of the path's samples with a stroke that a limit reduced [-].
    #[serde(rename = "held_back")]
    pub limited: f64,
    /// Share of the path's samples outside the range of the training [-].
    pub extrapolating: f64,
    /// Radius about the twin's tip that the robot's is expected in, median of the path, by the recordings left out in the training of
    /// the twin's residual network [m].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tip_band_m: Option<f64>,
    /// The command that made this.
    pub command: String,
    /// Commit of the program.
    pub commit: String,
}

impl crate::shared::outcome::Outcome for Outcome {}
