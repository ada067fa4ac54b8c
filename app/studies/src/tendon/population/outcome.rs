//! The numbers of `study population`.

use hysteron_report::verdict::{Criterion, Verdict};
use hysteron_workflow::shared::verdict::{compared, repeated};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::tendon::path_following::{Followed, FollowedMethod, paired_means};

/// The numbers of `study population`.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct PopulationMetrics {
    /// One for each robot.
    pub robots: Vec<PopulationRobot>,
}

/// A robot along every path, or why there is nothing.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct PopulationRobot {
    /// The robot.
    pub robot: String,
    /// One for each path.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub paths: Option<Vec<PopulationPath>>,
    /// Why a stage failed on it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub failed: Option<String>,
}

/// A path by every method.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct PopulationPath {
    /// The path.
    pub target: String,
    /// One for each method.
    pub methods: Vec<FollowedMethod>,
}

/// Ways to strokes.
pub(super) const METHODS: [&str; 6] = [
    "nominal scene",
    "fitted scene",
    "network of recorded data",
    "calibrated twin",
    "hybrid network",
    "what train writes",
];

impl PopulationRobot {
    /// Path by path, what each method came to; nothing of a robot on which a stage failed.
    pub(super) fn followed(&self) -> impl Iterator<Item = Vec<Option<Followed>>> {
        let paths = self.paths.iter().flatten();
        paths.map(|path| path.methods.iter().map(|method| method.followed.followed()).collect())
    }
}

/// Whether robots that are known from their recordings alone follow paths better than with a nominal scene.
pub(super) fn assess(metrics: &PopulationMetrics) -> Verdict {
    let paths = metrics.robots.iter().flat_map(PopulationRobot::followed);
    let cases: Vec<Vec<Option<f64>>> =
        paths.map(|path| path.into_iter().map(|one| Some(one?.nrmse_percent)).collect()).collect();
    let builder = Verdict::on(
        "robots that are known from their recordings alone follow paths better than with a nominal scene",
    );
    let methods = paired_means(&METHODS.map(str::to_owned), &cases);
    let builder = compared(builder, ("NRMSE, mean of the paths that all follow", "%"), &methods, METHODS[0]);
    let n = metrics.robots.len();
    let failed = metrics.robots.iter().filter(|robot| robot.failed.is_some()).count();
    let statement = format!("a stage failed on {failed} of {n} robots");
    let builder = builder.because(Criterion::Missing, failed as f64 / n.max(1) as f64, statement);
    repeated(builder, n - failed, "robot").verdict()
}
