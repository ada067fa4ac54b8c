//! The numbers of `study adaptation`.

use hysteron_report::verdict::{Criterion, Verdict};
use hysteron_twin::residual::AdaptedParts;
use hysteron_workflow::shared::verdict::{compared, repeated};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::tendon::numbers::mean;

/// The numbers of `study adaptation`.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct AdaptationMetrics {
    /// One for each target on each robot.
    pub rows: Vec<Row>,
}

/// A target on a robot, before and after adaptation; null where the rig did not carry the strokes out.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Row {
    /// Change of the robot.
    pub change: String,
    /// The target.
    pub target: String,
    /// Parts that the adaptation kept.
    pub kept: AdaptedParts,
    /// With the network of the robot as it was.
    pub before: Option<Tip>,
    /// With the adapted network.
    pub after: Option<Tip>,
    /// Part of the error at equal times that adaptation took away [-].
    pub gain: Option<f64>,
    /// Error of the twin on the unchanged robot along the target, at equal times [mm].
    pub unchanged_robot_aligned_rmse_mm: Option<f64>,
}

/// How closely a tip followed its target.
#[derive(Debug, Clone, Copy, Serialize, Deserialize, JsonSchema)]
pub struct Tip {
    /// Distance from the path [mm].
    pub rmse_mm: f64,
    /// Distance at equal times [mm].
    pub aligned_rmse_mm: f64,
    /// NRMSE [%].
    pub nrmse_percent: f64,
}

/// Name of the robot that has not changed.
pub(super) const UNCHANGED: &str = "unchanged";
/// The network of the robot as it was, with which the adapted one is compared.
const BEFORE: &str = "before";

/// Whether a minute of data makes the tip of a changed robot follow its targets better.
pub(super) fn assess(metrics: &AdaptationMetrics) -> Verdict {
    let changed = || metrics.rows.iter().filter(|row| row.change != UNCHANGED);
    let both: Vec<(Tip, Tip)> = changed().filter_map(|row| row.before.zip(row.after)).collect();
    let pairs = [
        (BEFORE, mean(both.iter().map(|(before, _)| before.aligned_rmse_mm))),
        ("after a minute of data", mean(both.iter().map(|(_, after)| after.aligned_rmse_mm))),
    ];
    let methods: Vec<(String, f64)> =
        pairs.into_iter().filter_map(|(name, error)| Some((name.to_owned(), error?))).collect();
    let builder = Verdict::on("a minute of data makes the tip of a changed robot follow its targets better");
    let builder = compared(builder, ("changed robots, distance at equal times", "mm"), &methods, BEFORE);
    let n = changed().count();
    let statement = format!("{} of {n} targets were not followed before and after", n - both.len());
    let builder = builder.because(Criterion::Missing, (n - both.len()) as f64 / n.max(1) as f64, statement);
    let mut changes: Vec<&str> = changed().map(|row| &row.change[..]).collect();
    changes.dedup();
    repeated(builder, changes.len(), "changed robot").verdict()
}
