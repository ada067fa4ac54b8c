//! The numbers of `study adaptation`.

use hysteron_twin::residual::AdaptedParts;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

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
