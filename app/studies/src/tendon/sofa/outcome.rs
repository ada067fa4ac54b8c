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

/// Comparisons in which both programs have one law.
pub(super) const SAME_LAW: [&str; 2] = ["polar factor against SOFA polar", "edges against SOFA large"];

/// Whether tip and tension are those of SOFA where the law is the same, up to the largest stroke.
pub(super) fn assess(found: &[Comparison]) -> Verdict {
    let claim = "with the same law and mesh, the twin bends and pulls as SOFA does";
    let largest = SAME_LAW.iter().filter_map(|name| found.iter().rfind(|one| one.comparison == *name));
    let builder = largest.fold(Verdict::on(claim), |builder, one| {
        let statement = |what: &str, of: &str, part: f64| {
            format!("{}: the {what} is off by at most {} % of {of}", one.comparison, digits(100.0 * part))
        };
        builder
            .because(
                Criterion::ErrorOverTarget,
                one.worst_tip,
                statement("tip", "its deflection", one.worst_tip),
            )
            .because(
                Criterion::ErrorOverTarget,
                one.worst_tension,
                statement("tension", "itself", one.worst_tension),
            )
    });
    builder.verdict()
}
