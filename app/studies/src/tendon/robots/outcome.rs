//! The numbers of `study robots`.

use hysteron_report::verdict::Verdict;
use hysteron_workflow::shared::verdict::repeated;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::tendon::coreact::TwinTable;

/// The numbers of `study robots`.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct RobotsMetrics {
    /// Twins of the ablation of every preset, and those of `typical` on the population around it.
    pub ladders: Vec<TwinTable>,
}

/// Whether twins that learned follow their robots better than those that did not.
pub(super) fn assess(metrics: &RobotsMetrics) -> Verdict {
    let claim = "a twin with a network follows other robots better than one without";
    let builder = metrics.ladders.iter().fold(Verdict::on(claim), |builder, table| table.assess(builder));
    repeated(builder, metrics.ladders.iter().map(TwinTable::repeats).sum(), "robot").verdict()
}
