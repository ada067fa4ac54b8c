//! The outcome of `track`.

use std::path::PathBuf;

use hysteron_actuator::health::Health;
use hysteron_report::verdict::Verdict;
use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize};

use crate::shared::outcome;
use crate::tendon::evaluate;

/// The outcome of `track`: of a path, how closely the tip followed it; of recorded strokes, the recordings.
#[derive(Debug, Clone, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum Outcome {
    /// The score of the repeats.
    Evaluated(Box<evaluate::Outcome>),
    /// The repeats alone.
    Recorded(Recorded),
}

/// Repeats of recorded strokes.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Recorded {
    /// Folder of the recordings.
    pub out: PathBuf,
    /// The recordings.
    pub repeats: Vec<PathBuf>,
    /// Condition of the servos, of a rig that has some.
    pub health: Option<Health>,
}

impl outcome::Outcome for Outcome {
    fn verdict(&self) -> Option<&Verdict> {
        match self {
            Self::Evaluated(outcome) => Some(&outcome.verdict),
            Self::Recorded(_) => None,
        }
    }
}

impl<'de> Deserialize<'de> for Outcome {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        outcome::by_key(deserializer, "repeats", Self::Recorded, |outcome| Self::Evaluated(Box::new(outcome)))
    }
}
