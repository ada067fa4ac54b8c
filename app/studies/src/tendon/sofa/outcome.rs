//! The numbers of `study sofa`.

use hysteron_report::verdict::{Criterion, Verdict};
use hysteron_workflow::shared::verdict::digits;
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

/// The comparison in which both programs have one law: SOFA's `polar` takes its frames from edges.
pub(super) const SAME_LAW: &str = "edges against SOFA polar";

/// Whether tip and tension are those of SOFA where the law is the same, up to the largest stroke.
pub(super) fn assess(found: &[Comparison]) -> Verdict {
    let claim = "with the same law and mesh, the twin bends and pulls as SOFA does";
    let Some(last) = found.iter().rfind(|one| one.comparison == SAME_LAW) else {
        return Verdict::on(claim).verdict();
    };
    let statement = |what: &str, of: &str, part: f64| {
        format!("{SAME_LAW}: the {what} is off by at most {} % of {of}", digits(100.0 * part))
    };
    let (tip, tension) = (last.worst_tip, last.worst_tension);
    Verdict::on(claim)
        .because(Criterion::ErrorOverTarget, tip, statement("tip", "its deflection", tip))
        .because(Criterion::ErrorOverTarget, tension, statement("tension", "itself", tension))
        .verdict()
}
