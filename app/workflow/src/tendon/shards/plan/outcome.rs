//! The outcome of `shards plan`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::estimate::CostEstimate;
use crate::Context;

/// A file that workers read.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct PlannedInput {
    /// Its name.
    pub name: String,
    /// SHA-256 of its bytes, and its name in the set.
    pub sha256: String,
}

/// The outcome of `shards plan`.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Outcome {
    /// Place of the set.
    pub url: String,
    /// SHA-256 of its manifest.
    pub manifest_sha256: String,
    /// Whether the same set was planned there before.
    pub was_there: bool,
    /// Name of the robot.
    pub robot: String,
    /// Name of the plan.
    pub plan: String,
    /// Trajectories.
    pub trajectories: usize,
    /// Samples of all.
    pub samples: u64,
    /// Number of shards.
    pub shards: usize,
    /// Files that workers read.
    pub inputs: Vec<PlannedInput>,
    /// Time and size of the set, where trajectories were simulated for it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub estimate: Option<CostEstimate>,
}

impl crate::shared::outcome::Outcome for Outcome {}

impl Outcome {
    /// Prints the set and its estimate.
    pub(super) fn print(&self, context: &Context) {
        let Self { plan, trajectories, samples, shards, url, .. } = self;
        let was_there = if self.was_there { ", as before" } else { "" };
        context.print(format_args!(
            "plan {plan}: {trajectories} trajectories, {samples} samples in {shards} shards{was_there}"
        ));
        if let Some(estimate) = &self.estimate {
            estimate.print(context);
        }
        context.print(format_args!("next, on every machine: hysteron shards work {url}"));
    }
}
