//! The numbers of `study ftdcr`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The numbers of `study ftdcr`.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct FtdcrMetrics {
    /// One for each fold.
    pub folds: Vec<FoldResult>,
    /// Errors over all folds.
    pub pooled: Vec<MethodError>,
}

/// One fold.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct FoldResult {
    /// Labels of the patterns that were held out.
    pub patterns: Vec<String>,
    /// Their rows.
    pub rows: usize,
    /// Rows without an equilibrium of the twin.
    pub rows_without_equilibrium: usize,
    /// Parameters of the reduced model.
    pub parameters: Vec<ParameterValue>,
    /// Why its fit ended.
    pub fit_ended: String,
    /// Parameters of the finite-element twin's own fit; null without one.
    pub twin_parameters: Option<Vec<f64>>,
    /// Errors by method.
    pub rmse_mm: Vec<MethodError>,
}

/// A fitted parameter.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct ParameterValue {
    /// Name of the parameter.
    pub name: String,
    /// Its value.
    pub value: f64,
}

/// Error of a method.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct MethodError {
    /// Name of the method.
    pub method: String,
    /// Root mean square error of the tip [mm].
    pub rmse_mm: f64,
}
