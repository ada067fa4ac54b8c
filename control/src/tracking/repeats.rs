//! How much repeats differ.

use super::TrackingScore;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Mean and spread of one metric over repeats, in the metric's unit.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Repeatability {
    /// Mean.
    pub mean: f64,
    /// Standard deviation of the repeats, n - 1 in its denominator.
    pub deviation: f64,
    /// Coefficient of variation, deviation over mean [-]; none where the mean is zero.
    pub variation: Option<f64>,
}

/// Mean and spread of a metric over repeats; `None` for fewer than two, or where one has no such metric.
///
/// # Reference
/// CoReAct paper, section V-B d: CV of RMSE, NRMSE and IoU over repeats.
pub fn repeatability(
    scores: &[TrackingScore],
    metric: impl Fn(&TrackingScore) -> Option<f64>,
) -> Option<Repeatability> {
    let values: Vec<f64> = scores.iter().map(metric).collect::<Option<_>>()?;
    if values.len() < 2 {
        return None;
    }
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let squares = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>();
    let deviation = (squares / (n - 1.0)).sqrt();
    Some(Repeatability { mean, deviation, variation: (mean != 0.0).then(|| deviation / mean.abs()) })
}
