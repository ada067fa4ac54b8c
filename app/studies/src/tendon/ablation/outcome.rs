//! The numbers of `study ablation`.

use hysteron_report::verdict::{Criterion, Verdict};
use hysteron_workflow::shared::verdict::{compared, repeated};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::tendon::path_following::{Followed, FollowedKeys, paired_means};

/// The numbers of `study ablation`.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct AblationMetrics {
    /// One for each robot.
    pub robots: Vec<AblatedRobot>,
}

/// A robot along every path.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct AblatedRobot {
    /// The robot.
    pub robot: String,
    /// One for each path.
    pub paths: Vec<AblationPath>,
}

/// A path by every ablation level.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct AblationPath {
    /// The path.
    pub target: String,
    /// One for each level.
    pub rungs: Vec<LevelResult>,
}

/// An ablation level.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct LevelResult {
    /// Name of the level.
    #[serde(rename = "rung")]
    pub level: String,
    /// How closely the tip followed the target.
    #[serde(flatten)]
    pub followed: FollowedKeys,
}

/// Names of the levels, the simplest first.
pub(super) const LEVELS: [&str; 6] = [
    "twin, no learning",
    "network, recorded minute",
    "the paper's network, hybrid data",
    "network, hybrid data",
    "calibrated twin",
    "+ adaptation",
];

impl AblatedRobot {
    /// Whether it is a member of a population, and no preset.
    pub(super) fn is_member(&self) -> bool {
        self.robot.contains('/')
    }

    /// Path by path, what each level came to.
    pub(super) fn followed(&self) -> impl Iterator<Item = Vec<Option<Followed>>> {
        self.paths.iter().map(|path| path.rungs.iter().map(|level| level.followed.followed()).collect())
    }
}

/// Whether learning makes the tip follow its targets better than the twin alone.
pub(super) fn assess(metrics: &AblationMetrics) -> Verdict {
    let levels = LEVELS.map(str::to_owned);
    let of = |is_member: bool| -> Vec<Vec<Option<f64>>> {
        let robots = metrics.robots.iter().filter(|robot| robot.is_member() == is_member);
        let paths = robots.flat_map(AblatedRobot::followed);
        paths.map(|path| path.into_iter().map(|one| Some(one?.nrmse_percent)).collect()).collect()
    };
    let builder = Verdict::on("learning makes the tip follow paths better than the twin alone");
    let groups = [("presets, NRMSE", of(false)), ("population, NRMSE", of(true))];
    let builder = groups.iter().fold(builder, |builder, (what, cases)| {
        compared(builder, (what, "%"), &paired_means(&levels, cases), LEVELS[0])
    });
    let paths = || metrics.robots.iter().flat_map(AblatedRobot::followed);
    let (n, refused) =
        (paths().count(), paths().filter(|path| path.last().is_none_or(Option::is_none)).count());
    let statement = format!("the rig refused {refused} of {n} paths by the last level");
    let builder = builder.because(Criterion::Missing, refused as f64 / n.max(1) as f64, statement);
    repeated(builder, metrics.robots.len(), "robot").verdict()
}
