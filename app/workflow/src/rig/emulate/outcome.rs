//! The outcome of `rig emulate`.

use hysteron_virtual_rig::emulator::TrafficCounts;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The outcome of `rig emulate`.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Outcome(pub TrafficCounts);

impl crate::shared::outcome::Outcome for Outcome {}
