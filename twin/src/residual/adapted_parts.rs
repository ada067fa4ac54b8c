//! Parts of an adaptation that are kept.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Parts of the adaptation that are kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum AdaptedParts {
    /// The model as it was.
    Nothing,
    /// Zeros, play and friction.
    Change,
    /// The linear correction.
    Correction,
    /// Both.
    Both,
}

impl AdaptedParts {
    /// From the fewest numbers to the most.
    pub(super) const ALL: [Self; 4] = [Self::Nothing, Self::Change, Self::Correction, Self::Both];

    pub(super) fn has_change(self) -> bool {
        matches!(self, Self::Change | Self::Both)
    }

    pub(super) fn has_correction(self) -> bool {
        matches!(self, Self::Correction | Self::Both)
    }
}
