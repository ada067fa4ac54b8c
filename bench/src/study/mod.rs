//! Comparisons with other programs and with real robots, and the whole chain in real time; each prints tables and
//! writes `metrics.json`.

pub mod adaptation;
pub mod chain;
pub mod convergence;
pub mod coreact;
pub mod edic;
pub mod followed;
pub mod ftdcr;
pub mod inverse;
pub mod ladder;
pub mod layouts;
pub mod population;
pub mod rig;
pub mod robots;
pub mod sensing;
pub mod sofa;
pub mod sorosim;
pub mod tentacle;

use std::path::Path;

use anyhow::Result;
use hysteron_base::{file, json};
pub use hysteron_fuzz::data_folder;
use serde_json::Value;

use crate::measure::machine;

/// Writes `folder/metrics.json`.
fn write_metrics(folder: &Path, study: &str, metrics: Value) -> Result<()> {
    let report = json!({
        "format": "hysteron-metrics",
        "version": 1,
        "study": study,
        "machine": machine(),
        "metrics": metrics,
    });
    Ok(file::write_bytes(&folder.join("metrics.json"), json::to_text(&report)?)?)
}

/// Distance of two points.
fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f64>().sqrt()
}

/// Root of the mean square.
fn rms(values: impl IntoIterator<Item = f64>) -> f64 {
    let (mut sum, mut n) = (0.0, 0.0);
    for value in values {
        sum += value * value;
        n += 1.0;
    }
    f64::sqrt(sum / n)
}
