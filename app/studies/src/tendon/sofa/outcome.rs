//! The numbers of `study sofa`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Worst relative differences of a comparison up to a stroke.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Comparison {
    /// Law of the twin, and the reference.
    pub comparison: String,
    /// Strokes up to this one [mm].
    pub to_stroke_mm: f64,
    /// Distance of the tips over the deflection [-].
    pub worst_tip: f64,
    /// Difference of the distances from rest over the deflection [-].
    pub worst_deflection: f64,
    /// Difference of the tensions of the pulled tendon [-].
    pub worst_tension: f64,
}
