//! The numbers of `study ftdcr`.

use hysteron_report::verdict::Verdict;
use hysteron_workflow::shared::verdict::{compared, repeated};
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

/// Methods that predict the tip. The last six get the rows of the finite-element twin alone, the very last
/// one the tip itself.
pub(super) const METHODS: [&str; 14] = [
    "constant curvature without play and weight",
    "constant curvature",
    "constant curvature + kernel ridge on its residual",
    "constant curvature + LSTM on its residual",
    "cubic regression on all strokes",
    "cubic regression on the segments' bending",
    "kernel regression",
    "LSTM without a model",
    "constant curvature + kernel ridge, on the twin's rows",
    "constant curvature, on the twin's rows",
    "FE twin, the constant-curvature model's parameters",
    "FE twin, fitted",
    "FE twin + CoReAct",
    "FE twin, led to the measured tip",
];
/// Places of constant curvature, and of the kernel ridge on its residual.
pub(super) const MODEL: usize = 1;
pub(super) const CORRECTED: usize = 2;
/// Method that the others are compared with, the simplest; and the one that is given what the others predict.
const SIMPLEST: &str = METHODS[0];
const GIVEN: &str = METHODS[METHODS.len() - 1];

/// Whether a method predicts the tip better than arcs of constant curvature.
pub(super) fn assess(metrics: &FtdcrMetrics) -> Verdict {
    let builder = Verdict::on(
        "the tip on patterns that were not fitted is predicted better than by arcs of constant curvature",
    );
    let methods = metrics.pooled.iter().filter(|one| one.method != GIVEN);
    let methods: Vec<(String, f64)> = methods.map(|one| (one.method.clone(), one.rmse_mm)).collect();
    let builder = compared(builder, ("error of the tip", "mm"), &methods, SIMPLEST);
    repeated(builder, metrics.folds.len(), "fold").verdict()
}
