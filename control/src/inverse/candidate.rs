//! The controllers that a training compares: each is one that could be used alone.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A controller to choose from, from the simplest on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Candidate {
    /// The cubic regression with its delay, without a network.
    StaticRegression,
    /// Kernel regression of what the cubic leaves, without a network.
    KernelRegression,
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
            Self::KernelRegression => "kernel regression",
            Self::RecordedNetwork => "network of recordings alone",
            Self::Network => "network",
        }
    }

    /// Whether it is a network: others are fitted in closed form, in no time.
    pub fn is_network(self) -> bool {
        matches!(self, Self::RecordedNetwork | Self::Network)
    }
}
