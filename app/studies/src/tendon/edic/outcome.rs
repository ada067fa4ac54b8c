//! The numbers of `study edic`.

use hysteron_report::verdict::{Criterion, Verdict};
use hysteron_workflow::shared::verdict::{compared, repeated};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::tendon::numbers::mean;
use crate::tendon::path_following::{Followed, paired_means};

/// The numbers of `study edic`.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct EdicMetrics {
    /// One for each path.
    pub paths: Vec<EdicPath>,
}

/// A path by every method.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct EdicPath {
    /// The path, by its name and size [mm].
    pub path: String,
    /// NRMSE of the paper's EDIC [%].
    pub paper_nrmse_percent: f64,
    /// Its overlap [-].
    pub paper_iou: f64,
    /// One for each method.
    pub methods: Vec<MethodRuns>,
}

/// A method on a path: a value for every seed whose strokes the rig ran, and repeat.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct MethodRuns {
    /// Name of the method.
    pub method: String,
    /// NRMSE [%].
    pub nrmse_percent: Vec<f64>,
    /// Overlap [-].
    pub iou: Vec<f64>,
    /// Root mean square distance at equal times [mm].
    pub aligned_rmse_mm: Vec<Option<f64>>,
    /// Lag behind the target [ms].
    pub lag_ms: Vec<Option<f64>>,
    /// Seeds whose strokes the rig did not run.
    pub seeds_refused: u64,
}

/// Method that the others are compared with: an inverse network on recorded data alone.
pub(super) const RECORDED: &str = "network, recorded data";

impl MethodRuns {
    /// Run by run.
    pub(super) fn followed(&self) -> Vec<Followed> {
        let runs = self.nrmse_percent.iter().zip(&self.iou).enumerate();
        let one = |(k, (nrmse_percent, iou)): (usize, (&f64, &f64))| Followed {
            nrmse_percent: *nrmse_percent,
            iou: *iou,
            aligned_rmse_mm: self.aligned_rmse_mm.get(k).copied().flatten(),
            lag_ms: self.lag_ms.get(k).copied().flatten(),
        };
        runs.map(one).collect()
    }
}

/// Whether ideal paths are followed, and better than by a network of recorded data alone.
pub(super) fn assess(metrics: &EdicMetrics) -> Verdict {
    let runs = || metrics.paths.iter().flat_map(|path| &path.methods);
    let names: Vec<String> = metrics
        .paths
        .first()
        .into_iter()
        .flat_map(|path| path.methods.iter().map(|one| one.method.clone()))
        .collect();
    let cases: Vec<Vec<Option<f64>>> = metrics
        .paths
        .iter()
        .map(|path| path.methods.iter().map(|one| mean(one.nrmse_percent.iter().copied())).collect())
        .collect();
    let methods = paired_means(&names, &cases);
    let builder = Verdict::on(
        "ideal paths are followed open loop, and better than by a network of recorded data alone",
    );
    let builder = compared(builder, ("NRMSE, mean of the paths that all follow", "%"), &methods, RECORDED);
    let best = methods.iter().map(|(_, error)| *error).min_by(f64::total_cmp);
    let builder = builder.because_of(Criterion::ErrorOverTarget, best.map(|error| error / 100.0), |error| {
        format!("the best method is off by {:.1} % of the path", 100.0 * error)
    });
    let (refused, run) = runs().fold((0, 0), |(refused, run), one| {
        (refused + one.seeds_refused, run + u64::from(!one.nrmse_percent.is_empty()))
    });
    let share = refused as f64 / (refused + run).max(1) as f64;
    let builder =
        builder.because(Criterion::Missing, share, format!("the rig refused strokes {refused} times"));
    repeated(builder, runs().map(|one| one.nrmse_percent.len()).max().unwrap_or(0), "seed or repeat")
        .verdict()
}
