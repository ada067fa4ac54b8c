//! The controllers that a training compares: each is one that could be used alone.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A controller to choose from, from the simplest on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Candidate {
    /// The cubic regression with its delay, without a network.
    StaticRegression,
    /// The network that learned from recordings of the rig alone.
    RecordedNetwork,
    /// The network that learned from all: recordings, and synthetic data where there are some.
    Network,
}

impl Candidate {
    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::StaticRegression => "static regression",
            Self::RecordedNetwork => "network of recordings alone",
            Self::Network => "network",
        }
    }
}
