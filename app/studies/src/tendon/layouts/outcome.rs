//! The numbers of `study layouts`.

use hysteron_report::verdict::Verdict;
use hysteron_workflow::shared::verdict::repeated;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::tendon::coreact::TwinTable;

/// The numbers of `study layouts`.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct LayoutMetrics {
    /// One for each layout.
    pub layouts: Vec<LayoutReach>,
    /// Twins of the ablation with these layouts.
    pub ladder: TwinTable,
}

/// The identification with a layout.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct LayoutReach {
    /// Name of the layout.
    pub layout: String,
    /// Singular values of ∂tip/∂s*, in the median of all samples [-].
    pub singular_values: [f64; 3],
    /// Median and 99th percentile of the distance left, each in the mean of the recordings [mm].
    pub left_median_p99_mm: [f64; 2],
}

/// Whether fewer auxiliary tendons do better than the most.
pub(super) fn assess(metrics: &LayoutMetrics) -> Verdict {
    let builder = Verdict::on("fewer auxiliary tendons bring the twin closer to the robot than the most");
    repeated(metrics.ladder.assess(builder), metrics.ladder.repeats(), "seed").verdict()
}
