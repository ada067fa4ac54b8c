//! The numbers of `study coreact`.

use hysteron_report::verdict::{Criterion, Verdict, VerdictBuilder};
use hysteron_workflow::shared::verdict::{compared, repeated};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::tendon::numbers::{mean, rms};
use crate::tendon::outcome::StudyTable;

/// The numbers of `study coreact`.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct CoreactMetrics {
    /// Twins of the ablation of `typical`, and the best of them by a tracker without drift.
    pub ladders: Vec<TwinTable>,
    /// Rollouts on random plans.
    pub stability: Stability,
}

/// All twins of a robot, or of several, on the test trajectories.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct TwinTable {
    /// The robot.
    pub robot: String,
    /// Its twins.
    pub twins: Vec<TwinErrors>,
}

/// One twin on the test trajectories.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct TwinErrors {
    /// Name of the twin.
    pub twin: String,
    /// Its errors, path by path.
    pub nrmse: Vec<PathErrors>,
}

/// NRMSE on a test trajectory, one for each seed or robot.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct PathErrors {
    /// Name of the trajectory.
    pub path: String,
    /// Along x [%].
    pub x_percent: Vec<f64>,
    /// Along y [%].
    pub y_percent: Vec<f64>,
    /// Along z [%].
    pub z_percent: Vec<f64>,
}

/// Rollouts on random plans.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Stability {
    /// Error of the tip over that of the twin without a network, plan by plan [-].
    pub ratio_to_bare: Vec<f64>,
    /// Plans on which the network makes the error larger by more than 10 %.
    pub worse_by_10_percent: Vec<usize>,
}

impl PathErrors {
    /// Of the errors along x, y and z [%].
    pub fn new(path: &str, [x_percent, y_percent, z_percent]: [Vec<f64>; 3]) -> Self {
        Self { path: path.to_owned(), x_percent, y_percent, z_percent }
    }

    /// Along x, y and z [%].
    pub fn axes(&self) -> [&Vec<f64>; 3] {
        [&self.x_percent, &self.y_percent, &self.z_percent]
    }
}

impl TwinTable {
    /// The twins on every test, as a table.
    pub fn table(&self) -> StudyTable {
        let tests = self.twins.first().map_or(&[][..], |row| &row.nrmse);
        let of_test = |test: &PathErrors| ["x", "y", "z"].map(|axis| format!("{}, {axis} [%]", test.path));
        let headings = ["Twin".to_owned()].into_iter().chain(tests.iter().flat_map(of_test));
        let row = |twin: &TwinErrors| {
            let values = twin.nrmse.iter().flat_map(|path| path.axes().map(|values| spread(values)));
            std::iter::once(twin.twin.clone()).chain(values).collect()
        };
        StudyTable::new(format!("NRMSE of the tip: {}", self.robot), headings, self.twins.iter().map(row))
    }

    /// Adds how the best twin compares with the first, mean of all axes, tests and repeats.
    pub(crate) fn assess(&self, builder: VerdictBuilder) -> VerdictBuilder {
        let mean_of = |twin: &TwinErrors| {
            let values = twin.nrmse.iter().flat_map(|path| path.axes().into_iter().flatten().copied());
            Some((twin.twin.clone(), mean(values)?))
        };
        let methods: Vec<(String, f64)> = self.twins.iter().filter_map(mean_of).collect();
        let first = self.twins.first().map_or("", |twin| &twin.twin);
        compared(builder, (&format!("{}, NRMSE of the tip", self.robot), "%"), &methods, first)
    }

    /// Most repeats of a twin: seeds or robots.
    pub(crate) fn repeats(&self) -> usize {
        let paths = self.twins.iter().flat_map(|twin| &twin.nrmse);
        paths.map(|path| path.x_percent.len()).max().unwrap_or(0)
    }
}

/// Whether a twin that learned follows the robot better than one that did not.
pub(super) fn assess(metrics: &CoreactMetrics) -> Verdict {
    let builder =
        Verdict::on("a twin with a network follows the robot better than one without, also on random plans");
    // The second table compares with the drift of the tracker, which is no twin.
    let (first, ratios) = (metrics.ladders.first(), &metrics.stability.ratio_to_bare);
    let builder = first.into_iter().fold(builder, |builder, table| table.assess(builder));
    let ratio = (!ratios.is_empty()).then(|| rms(ratios.iter().copied()));
    let builder = builder.because_of(Criterion::ErrorOverBaseline, ratio, |ratio| {
        format!("random plans: the error of the tip is {:.0} % of that without a network", 100.0 * ratio)
    });
    repeated(builder, first.map_or(0, TwinTable::repeats), "seed").verdict()
}

/// Mean of these, and their deviation where there is more than one.
fn spread(values: &[f64]) -> String {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let variance = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / f64::max(n - 1.0, 1.0);
    if values.len() > 1 { format!("{mean:.2} ± {:.2}", variance.sqrt()) } else { format!("{mean:.2}") }
}
