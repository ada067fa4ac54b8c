//! The outcome of `arm record`.

use std::path::PathBuf;

use hysteron_rig::teleoperation::ArmsOutcome;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::shared::outcome;

/// The outcome of `arm record`.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Outcome {
    /// The recording.
    pub recording: PathBuf,
    /// Number of samples.
    pub rows: usize,
    /// Samples that were not measured and are filled in.
    pub filled_in: usize,
    /// Cycles that came late.
    pub late_cycles: usize,
}

impl outcome::Outcome for Outcome {}

impl Outcome {
    /// Of a recording that came to its end.
    pub(super) fn new(recorded: &ArmsOutcome) -> Self {
        Self {
            recording: recorded.out.clone(),
            rows: recorded.n_rows,
            filled_in: recorded.n_gaps,
            late_cycles: recorded.n_late,
        }
    }
}
