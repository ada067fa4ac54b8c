//! The numbers of `study inverse`.

use hysteron_report::verdict::Verdict;
use hysteron_workflow::shared::verdict::{compared, repeated};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::methods::Errors;

/// The numbers of `study inverse`; a robot without recordings is skipped.
#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
pub struct InverseMetrics {
    /// The trunk.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub trunk: Option<TrunkResult>,
    /// The three-segment robot.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ftdcr: Option<SegmentsResult>,
}

/// Errors on the trunk, seed by seed and method by method.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct TrunkResult {
    /// Names of the methods.
    pub methods: Vec<String>,
    /// Errors of the motor angles on test blocks [deg].
    pub unseen_blocks_deg: Vec<Errors>,
    /// The same with 200 g at the tip [deg].
    pub loaded_deg: Vec<Errors>,
    /// Delays that the methods chose [s].
    pub delays_s: Vec<Errors>,
    /// The path under load against the one without, same commands.
    pub path_under_load: PathDifference,
}

/// How far two recorded paths of the same commands are apart, in the horizontal plane.
#[derive(Debug, Clone, Copy, Serialize, Deserialize, JsonSchema)]
pub struct PathDifference {
    /// Root mean square distance at equal times [mm].
    pub aligned_rmse_mm: Option<f64>,
    /// Lag of the second path [s].
    pub lag_s: Option<f64>,
    /// Chamfer distance [mm].
    pub chamfer_mm: f64,
    /// Hausdorff distance [mm].
    pub hausdorff_mm: f64,
    /// Fréchet distance [mm].
    pub frechet_mm: f64,
}

/// Errors on the three-segment robot.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct SegmentsResult {
    /// Names of the methods.
    pub methods: Vec<String>,
    /// Errors of the strokes on test patterns, fold by fold and method by method [mm].
    pub folds_mm: Vec<Errors>,
}

/// Whether a network finds strokes better than a static regression.
pub(super) fn assess(metrics: &InverseMetrics) -> Verdict {
    let mut builder =
        Verdict::on("a network finds the strokes of a recorded path better than a static regression");
    for test in metrics.tests() {
        let InverseTest { what, unit, methods, errors } = test;
        let mean = |k: usize| errors.iter().map(|row| row[k]).sum::<f64>() / errors.len() as f64;
        let all: Vec<(String, f64)> =
            methods.iter().enumerate().map(|(k, name)| (name.clone(), mean(k))).collect();
        // The first method is the simplest.
        let simplest = methods.first().map_or("", String::as_str);
        builder = compared(builder, (&format!("{what}, error"), unit), &all, simplest);
    }
    let repeats = metrics.tests().iter().map(|test| test.errors.len()).min().unwrap_or(0);
    repeated(builder, repeats, "seed or fold").verdict()
}

/// A test with the errors of all methods.
pub(super) struct InverseTest<'a> {
    /// Name of the test recordings.
    pub what: &'static str,
    /// Unit of the errors.
    pub unit: &'static str,
    /// Names of the methods.
    pub methods: &'a [String],
    /// Their errors, repeat by repeat.
    pub errors: &'a [Errors],
}

impl InverseMetrics {
    /// Every test of a robot whose recordings are there.
    pub(super) fn tests(&self) -> Vec<InverseTest<'_>> {
        let trunk = self.trunk.iter().flat_map(|one| {
            let test = |what, errors| InverseTest { what, unit: "deg", methods: &one.methods, errors };
            [
                test("trunk, test blocks", &one.unseen_blocks_deg[..]),
                test("trunk, test blocks with 200 g at the tip", &one.loaded_deg[..]),
            ]
        });
        let segments = self.ftdcr.iter().map(|one| InverseTest {
            what: "three segments, test patterns",
            unit: "mm",
            methods: &one.methods,
            errors: &one.folds_mm,
        });
        trunk.chain(segments).collect()
    }
}
