//! The outcome of `rig emulate`.

use hysteron_virtual_rig::emulator::Counts;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The outcome of `rig emulate`.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Outcome(pub Counts);

impl crate::shared::outcome::Outcome for Outcome {}
