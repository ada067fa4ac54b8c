//! The numbers of `study inverse`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The numbers of `study inverse`; a robot without recordings is skipped.
#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
pub struct InverseMetrics {
    /// The trunk.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub trunk: Option<TrunkResult>,
    /// The three-segment robot.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ftdcr: Option<SegmentsResult>,
}

/// Errors on the trunk, seed by seed and method by method.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct TrunkResult {
    /// Names of the methods.
    pub methods: Vec<String>,
    /// Errors of the motor angles on test blocks [deg].
    pub unseen_blocks_deg: Vec<[f64; 5]>,
    /// The same with 200 g at the tip [deg].
    pub loaded_deg: Vec<[f64; 5]>,
    /// Delays that the methods chose [s].
    pub delays_s: Vec<[f64; 5]>,
    /// The path under load against the one without, same commands.
    pub path_under_load: PathDifference,
}

/// How far two recorded paths of the same commands are apart, in the horizontal plane.
#[derive(Debug, Clone, Copy, Serialize, Deserialize, JsonSchema)]
pub struct PathDifference {
    /// Root mean square distance at equal times [mm].
    pub aligned_rmse_mm: Option<f64>,
    /// Lag of the second path [s].
    pub lag_s: Option<f64>,
    /// Chamfer distance [mm].
    pub chamfer_mm: f64,
    /// Hausdorff distance [mm].
    pub hausdorff_mm: f64,
    /// Fréchet distance [mm].
    pub frechet_mm: f64,
}

/// Errors on the three-segment robot.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct SegmentsResult {
    /// Names of the methods.
    pub methods: Vec<String>,
    /// Errors of the strokes on test patterns, fold by fold and method by method [mm].
    pub folds_mm: Vec<[f64; 5]>,
}
