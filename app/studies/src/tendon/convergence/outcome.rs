//! The numbers of `study convergence`.

use hysteron_report::verdict::{Criterion, Verdict};
use hysteron_workflow::shared::verdict::digits;
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

/// Beginning of the names of meshes that are refined.
pub(super) const TUBE: &str = "tube";

/// Orders of tetrahedra, with their names.
pub(super) const ORDERS: [(u32, &str); 2] = [(1, "linear"), (2, "quadratic")];

impl MeshResolution {
    /// Whether it is one of the meshes that are refined, of this order and with rings of this radius [mm].
    pub(super) fn is_refined(&self, order: u32, ring_mm: f64) -> bool {
        self.mesh.starts_with(TUBE) && self.order == order && self.ring_mm == ring_mm
    }
}

/// Whether the deflection of the tip is converged: what the last refinement changes, at the largest stroke that both meshes reach.
pub(super) fn assess(found: &[MeshResolution]) -> Verdict {
    let mut builder = Verdict::on("the finest tubes show the deflection of a tube");
    for ring in rings(found) {
        for (order, name) in ORDERS {
            let all: Vec<&MeshResolution> = found.iter().filter(|one| one.is_refined(order, ring)).collect();
            let [.., coarse, fine] = &all[..] else { continue };
            let both = coarse.deflection_mm.iter().zip(&fine.deflection_mm).zip(&fine.stroke_mm);
            let last = both.filter_map(|((a, b), stroke)| Some(((*a)?, (*b)?, *stroke))).next_back();
            let Some((before, after, stroke)) = last else { continue };
            let (change, carried) =
                ((before / after - 1.0).abs(), if ring > 0.0 { "rings" } else { "points" });
            let statement = format!(
                "{name} tetrahedra, tendons on {carried}: the last refinement changes the deflection at {stroke:.0} mm by {} %",
                digits(100.0 * change)
            );
            builder = builder.because(Criterion::ErrorOverTarget, change, statement);
        }
    }
    let n_failed = found.iter().filter(|one| one.failure.is_some()).count();
    let statement = format!("{n_failed} of {} meshes did not reach the last stroke", found.len());
    builder.because(Criterion::Missing, n_failed as f64 / found.len().max(1) as f64, statement).verdict()
}

/// Radii of the rings [mm], in their order.
pub(super) fn rings(found: &[MeshResolution]) -> Vec<f64> {
    let mut rings: Vec<f64> = found.iter().map(|one| one.ring_mm).collect();
    rings.dedup();
    rings
}
