//! The numbers of `study convergence`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// One mesh under the pull; null where it was not reached.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct MeshResolution {
    /// Name of the mesh.
    pub mesh: String,
    /// Order of its tetrahedra.
    pub order: u32,
    /// Law of the material.
    pub law: String,
    /// Radius of the rings that carry tendon points; 0 for points [mm].
    pub ring_mm: f64,
    /// Degrees of freedom.
    pub n_unknowns: usize,
    /// Strokes reported [mm].
    pub stroke_mm: [f64; 3],
    /// Deflection of the tip there [mm].
    pub deflection_mm: [Option<f64>; 3],
    /// Tension of the pulled tendon there [N].
    pub tension_n: [Option<f64>; 3],
    /// Stroke that was reached [mm].
    pub reached_mm: f64,
    /// Why no more was reached.
    pub failure: Option<String>,
}
