//! The outcome of `arm emulate`: traffic on both ports.

use hysteron_virtual_rig::emulator::TrafficCounts;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::shared::outcome;

/// The outcome of `arm emulate`.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Outcome {
    /// The leader's port.
    pub leader: PortCounts,
    /// The follower's port.
    pub follower: PortCounts,
}

impl outcome::Outcome for Outcome {}

/// Traffic on an emulated port.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct PortCounts {
    /// Instructions with a right checksum.
    pub instructions: u64,
    /// Answers sent.
    pub answers: u64,
}

impl PortCounts {
    pub(super) fn new(counts: &TrafficCounts) -> Self {
        Self { instructions: counts.instructions, answers: counts.answers }
    }
}
