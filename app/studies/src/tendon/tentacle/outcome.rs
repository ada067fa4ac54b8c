//! The numbers of `study tentacle`.

use hysteron_report::verdict::{Criterion, Verdict};
use hysteron_workflow::shared::verdict::{compared, repeated};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::holds::N_MARKERS;

/// The numbers of `study tentacle`.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct TentacleMetrics {
    /// One for each hold, with nominal parameters.
    pub holds: Vec<HoldErrors>,
    /// Errors over the holds.
    pub summary: Vec<PooledError>,
    /// Fitted parameters, of a study that is not quick.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fits: Option<Vec<ParameterFit>>,
    /// Residual tensions on top of the last fit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub residual_tensions: Option<ResidualTensions>,
}

/// A hold with nominal parameters.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct HoldErrors {
    /// Its number, from 1.
    pub hold: usize,
    /// Its session.
    pub session: String,
    /// Tensions of both tendons [N].
    pub tensions_n: [f64; 2],
    /// Distance of every marker [mm].
    pub marker_error_mm: [f64; N_MARKERS],
    /// Root mean square of these [mm].
    pub rmse_mm: f64,
}

/// Errors over several holds, compared with rod models.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct PooledError {
    /// The holds, and how markers are pooled.
    pub over: String,
    /// Of this twin [mm].
    pub rmse_mm: f64,
    /// Of a rod model of the project's own [mm].
    pub own_rod_mm: Option<f64>,
    /// Of the published rod model [mm].
    pub published_rod_mm: Option<f64>,
}

/// A set of fitted parameters.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct ParameterFit {
    /// Name of the set.
    pub set: String,
    /// Mean of the markers' root mean square errors [mm].
    pub mean_of_markers_rmse_mm: f64,
    /// The same of holds that were not fitted [mm].
    pub left_out_mean_of_markers_rmse_mm: f64,
    /// Whether the fit converged.
    pub converged: bool,
    /// Its parameters.
    pub parameters: Vec<FittedValue>,
}

/// A fitted parameter.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct FittedValue {
    /// Name of the parameter.
    pub name: String,
    /// Value at the start.
    pub start: f64,
    /// Value that was found.
    pub value: f64,
    /// Its standard error, where it has one.
    pub standard_error: Option<f64>,
    /// Whether the data determine it.
    pub is_fitted: bool,
}

/// Residual tensions that bring the markers to where they were measured.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct ResidualTensions {
    /// Auxiliary cables.
    pub cables: usize,
    /// One for each way in which holds share them.
    pub readings: Vec<SharedTensions>,
}

/// Residual tensions that holds share.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct SharedTensions {
    /// How holds share them.
    pub sharing: String,
    /// Mean of the markers' root mean square errors [mm].
    pub rmse_mm: f64,
    /// The same of test holds [mm].
    pub left_out_rmse_mm: Option<f64>,
}

/// Name of the simplest baseline, the rod model of the project's own.
const ROD: &str = "own rod model";

impl TentacleMetrics {
    /// Methods with their mean of the markers' root mean square errors over session B [mm], fits on the holds that were left out.
    pub(super) fn methods(&self) -> Vec<(String, f64)> {
        // The one that the published rod model stands beside.
        let nominal = self.summary.iter().find(|one| one.published_rod_mm.is_some());
        let nominal = nominal.into_iter().flat_map(|one| {
            [
                (ROD, one.own_rod_mm),
                ("published rod model", one.published_rod_mm),
                ("twin, nominal parameters", Some(one.rmse_mm)),
            ]
        });
        let nominal = nominal.filter_map(|(name, error)| Some((name.to_owned(), error?)));
        let fits = self.fits.iter().flatten();
        let fits =
            fits.map(|fit| (format!("twin, fitted: {}", fit.set), fit.left_out_mean_of_markers_rmse_mm));
        let shared = self.residual_tensions.iter().flat_map(|one| &one.readings);
        let shared = shared.filter_map(|one| {
            Some((format!("twin, residual tensions {}", one.sharing), one.left_out_rmse_mm?))
        });
        nominal.chain(fits).chain(shared).collect()
    }
}

/// Whether the twin says more of the markers than a rod model.
pub(super) fn assess(metrics: &TentacleMetrics) -> Verdict {
    let builder = Verdict::on("the twin predicts the markers of a recorded tentacle better than a rod model");
    let methods = metrics.methods();
    let builder =
        compared(builder, ("error of the markers on holds that were not fitted", "mm"), &methods, ROD);
    let best = metrics
        .fits
        .iter()
        .flatten()
        .min_by(|a, b| a.left_out_mean_of_markers_rmse_mm.total_cmp(&b.left_out_mean_of_markers_rmse_mm));
    let ratio = best.map(|fit| fit.left_out_mean_of_markers_rmse_mm / fit.mean_of_markers_rmse_mm);
    let builder = builder.because_of(Criterion::HeldOutOverFitted, ratio, |ratio| {
        format!("the error on a hold that was left out is {ratio:.2} times that on those that were fitted")
    });
    repeated(builder, metrics.holds.len(), "hold").verdict()
}
