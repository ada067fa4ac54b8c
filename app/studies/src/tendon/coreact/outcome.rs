//! The numbers of `study coreact`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

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
    /// Rows of cells: the robot, and a row for each twin.
    pub fn cells(&self) -> Vec<Vec<String>> {
        let tests = self.twins.first().map_or(&[][..], |row| &row.nrmse);
        let heading = tests
            .iter()
            .flat_map(|test| [format!("{} x [%]", test.path), "y [%]".to_owned(), "z [%]".to_owned()]);
        let mut cells = vec![std::iter::once("NRMSE".to_owned()).chain(heading).collect::<Vec<_>>()];
        for row in &self.twins {
            let values = row.nrmse.iter().flat_map(|path| path.axes().map(|values| spread(values)));
            cells.push(std::iter::once(row.twin.clone()).chain(values).collect());
        }
        cells
    }
}

/// Mean of these, and their deviation where there is more than one.
fn spread(values: &[f64]) -> String {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let variance = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / f64::max(n - 1.0, 1.0);
    if values.len() > 1 { format!("{mean:.2} ± {:.2}", variance.sqrt()) } else { format!("{mean:.2}") }
}
