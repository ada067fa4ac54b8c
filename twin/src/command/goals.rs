//! Where the tip is to go, sample by sample.

use std::path::Path;

use hysteron_base::{BadInput, Recording};

use crate::inverse::TipGoal;

/// Weight of the tensions against the tip error [-], see [`TipGoal::regularisation`]: enough to choose among
/// strokes that reach the goal alike, too little to hold the tip back.
const REGULARISATION: f64 = 1e-6;

/// Positions of the tip to reach.
#[derive(Debug, Clone)]
pub struct Goals<'a> {
    /// Coordinates x, y, z (n_samples each) [m].
    positions: [&'a [f64]; 3],
    /// Distance that counts as reached [m].
    tolerance: f64,
}

impl<'a> Goals<'a> {
    /// Takes the tip out of `recording`, which was read from `path`.
    pub fn new(recording: &'a Recording, path: &Path, tolerance: f64) -> Result<Self, BadInput> {
        let coordinate = |axis: &str| {
            recording.require(&format!("tip_{axis}_m")).map_err(|bad| {
                bad.hint(format!("goals are tip_x, tip_y and tip_z; in a CSV, name the column tip_{axis}_mm"))
                    .within(path.display())
            })
        };
        Ok(Self { positions: [coordinate("x")?, coordinate("y")?, coordinate("z")?], tolerance })
    }

    /// Coordinates x, y, z (n_samples each) [m].
    pub fn positions(&self) -> [&'a [f64]; 3] {
        self.positions
    }

    /// Distance that counts as reached [m].
    pub fn tolerance(&self) -> f64 {
        self.tolerance
    }

    /// The goal of sample `row`.
    pub fn tip_goal(&self, row: usize) -> TipGoal {
        TipGoal {
            position: self.positions.map(|values| Some(values[row])),
            tolerance: self.tolerance,
            regularisation: REGULARISATION,
            least_gain: 0.0,
        }
    }

    /// Distance of a tip (n_samples or fewer) from the goals [m].
    pub fn errors(&self, tip: [&[f64]; 3]) -> Vec<f64> {
        let square = |row: usize, c: usize| (self.positions[c][row] - tip[c][row]).powi(2);
        (0..tip[0].len()).map(|row| (0..3).map(|c| square(row, c)).sum::<f64>().sqrt()).collect()
    }
}
