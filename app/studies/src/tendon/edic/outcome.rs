//! The numbers of `study edic`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The numbers of `study edic`.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct EdicMetrics {
    /// One for each path.
    pub paths: Vec<EdicPath>,
}

/// A path by every method.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct EdicPath {
    /// The path, by its name and size [mm].
    pub path: String,
    /// NRMSE of the paper's EDIC [%].
    pub paper_nrmse_percent: f64,
    /// Its overlap [-].
    pub paper_iou: f64,
    /// One for each method.
    pub methods: Vec<MethodRuns>,
}

/// A method on a path: a value for every seed whose strokes the rig ran, and repeat.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct MethodRuns {
    /// Name of the method.
    pub method: String,
    /// NRMSE [%].
    pub nrmse_percent: Vec<f64>,
    /// Overlap [-].
    pub iou: Vec<f64>,
    /// Root mean square distance at equal times [mm].
    pub aligned_rmse_mm: Vec<Option<f64>>,
    /// Lag behind the target [ms].
    pub lag_ms: Vec<Option<f64>>,
    /// Seeds whose strokes the rig did not run.
    pub seeds_refused: u64,
}
