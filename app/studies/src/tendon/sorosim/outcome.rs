//! The numbers of `study sorosim`.

use hysteron_report::verdict::{Criterion, Verdict};
use hysteron_workflow::shared::verdict::digits;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// All shapes with one resolution of the mesh.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct RodResolution {
    /// Number of shapes.
    pub shapes: usize,
    /// Sides of the section.
    pub sides: u32,
    /// Layers of the mesh.
    pub layers: u32,
    /// Degrees of freedom.
    pub n_unknowns: usize,
    /// Time of all shapes on two threads [s].
    pub seconds_on_two_threads: f64,
    /// Worst relative residual of a shape [-].
    pub worst_relative_residual: f64,
    /// Iterations of Newton's method, mean over the shapes.
    pub iterations_per_shape: f64,
    /// Distances from the reference.
    pub error_percent_of_length: StationErrors,
}

/// Distances from the reference, over the length of the rod.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct StationErrors {
    /// At mid-length.
    #[serde(rename = "mid-length")]
    pub mid_length: ErrorStatistics,
    /// At the tip.
    pub tip: ErrorStatistics,
    /// At all stations but the clamp.
    #[serde(rename = "all stations but the clamp")]
    pub all: ErrorStatistics,
}

/// Errors over the shapes [%].
#[derive(Debug, Clone, Copy, Serialize, Deserialize, JsonSchema)]
pub struct ErrorStatistics {
    /// Median.
    pub median: f64,
    /// Mean.
    pub mean: f64,
    /// Value that 95 % stay below.
    pub p95: f64,
    /// Largest.
    pub max: f64,
}

impl StationErrors {
    /// Names of the stations with their errors.
    pub(super) fn named(&self) -> [(&'static str, &ErrorStatistics); 3] {
        [("mid-length", &self.mid_length), ("tip", &self.tip), ("all stations but the clamp", &self.all)]
    }
}

/// Whether the finest rod takes the shapes of the reference.
pub(super) fn assess(found: &[RodResolution]) -> Verdict {
    let builder = Verdict::on("the finite-element rod takes the shapes of SoRoSim");
    let Some(finest) = found.iter().max_by_key(|one| one.n_unknowns) else { return builder.verdict() };
    let ErrorStatistics { p95, max, .. } = finest.error_percent_of_length.tip;
    let statement = format!(
        "the tip is off by {} % of the length at most in 95 % of {} shapes, and by {} % in the worst",
        digits(p95),
        finest.shapes,
        digits(max)
    );
    builder.because(Criterion::ErrorOverTarget, p95 / 100.0, statement).verdict()
}
