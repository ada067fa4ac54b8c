//! Error by the locking of linear tetrahedra on a robot: for its commands, and for a recording.

use hysteron_base::{PrescribedQuantity, Scene};
use hysteron_fem::{Cells, Mesh};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::Result;
use crate::coreact::distance;
use crate::locking::{LockedMove, Locking};
use crate::model::{Target, Twin};
use crate::state::TwinState;

/// Samples of a recording that are tried for the one that moves the tip farthest.
const MAX_SAMPLES: usize = 200;
/// Motion below which no share is formed [m].
const TINY: f64 = 1e-9;

/// Error by the locking of linear tetrahedra on a robot.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum LockingEstimate {
    /// The mesh has ten-node tetrahedra.
    TenNode,
    /// The mesh is too large for an estimate.
    NotEstimated {
        /// Its nodes.
        nodes: usize,
    },
    /// The tip's motion at rest, to first order.
    Estimated(Vec<LockingComparison>),
}

/// The same command for linear and ten-node tetrahedra.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct LockingComparison {
    /// Command that moves the tip.
    pub command: String,
    /// Distance of the tip from rest with this mesh [m].
    pub tip_m: f64,
    /// The same with ten-node tetrahedra [m].
    pub tip_ten_node_m: f64,
    /// Largest tension with this mesh [N].
    pub tension_n: f64,
    /// The same with ten-node tetrahedra [N].
    pub tension_ten_node_n: f64,
    /// Share of the tip's motion that this mesh loses [-]; negative where it moves farther.
    pub loss: f64,
    /// How many times stiffer this mesh is, in tension (or load) per motion of the tip [-].
    pub stiffness_ratio: f64,
}

impl LockingComparison {
    /// Of one command.
    pub fn new(command: String, moved: &LockedMove) -> Self {
        Self {
            command,
            tip_m: moved.tip,
            tip_ten_node_m: moved.tip_quadratic,
            tension_n: moved.tension,
            tension_ten_node_n: moved.tension_quadratic,
            loss: moved.loss(),
            stiffness_ratio: moved.gain()
                * if moved.tension_quadratic > 0.0 { moved.tension / moved.tension_quadratic } else { 1.0 },
        }
    }
}

/// The two discretisations of a scene, where they can be compared.
#[derive(Debug, Clone)]
pub struct LockingEstimator {
    locking: Option<Locking>,
    estimate: LockingEstimate,
    drives: Vec<PrescribedQuantity>,
    names: Vec<String>,
}

impl LockingEstimator {
    /// Factorises both discretisations.
    ///
    /// # Errors
    /// Those of the twin.
    pub fn new(scene: &Scene, mesh: &Mesh) -> Result<Self> {
        let locking = Locking::new(scene, mesh)?;
        let estimate = match (&locking, &mesh.cells) {
            (_, Cells::Tet10(_)) => LockingEstimate::TenNode,
            (None, Cells::Tet4(_)) => LockingEstimate::NotEstimated { nodes: mesh.nodes.len() },
            (Some(_), Cells::Tet4(_)) => LockingEstimate::Estimated(Vec::new()),
        };
        let drives = scene.tendons.iter().map(|tendon| tendon.drive).collect();
        let names = scene.tendons.iter().map(|tendon| tendon.name.clone()).collect();
        let mut new = Self { locking, estimate, drives, names };
        let comparisons = new.compare_each();
        if let LockingEstimate::Estimated(list) = &mut new.estimate {
            *list = comparisons;
        }
        Ok(new)
    }

    /// Every tendon alone, and the loads alone.
    fn compare_each(&self) -> Vec<LockingComparison> {
        let Some(locking) = &self.locking else { return Vec::new() };
        let free = vec![Target::Free; self.drives.len()];
        let mut found = Vec::new();
        for (j, (drive, name)) in self.drives.iter().zip(&self.names).enumerate() {
            let mut targets = free.clone();
            let command = match drive {
                PrescribedQuantity::Tension => {
                    targets[j] = Target::Tension(1.0);
                    format!("pulling {name} with 1 N")
                }
                PrescribedQuantity::Stroke | PrescribedQuantity::Free => {
                    targets[j] = Target::Stroke(1e-3);
                    format!("pulling {name} by 1 mm")
                }
            };
            found.extend(locking.moved(&targets, 0.0).map(|moved| LockingComparison::new(command, &moved)));
        }
        let loads = locking.moved(&free, 1.0).filter(|moved| moved.tip_quadratic > TINY);
        found.extend(loads.map(|moved| LockingComparison::new("weight and forces alone".to_owned(), &moved)));
        found
    }

    /// Locking estimate of the robot, for all its commands.
    pub fn estimate(&self) -> &LockingEstimate {
        &self.estimate
    }

    /// The command by which this mesh is stiffest, where it was compared.
    pub fn stiffest(&self) -> Option<&LockingComparison> {
        let LockingEstimate::Estimated(list) = &self.estimate else { return None };
        list.iter().max_by(|a, b| a.stiffness_ratio.total_cmp(&b.stiffness_ratio))
    }

    /// The sample whose targets move the tip farthest, compared. `targets` gives those of a sample.
    pub fn farthest(&self, n_samples: usize, targets: impl Fn(usize) -> Vec<Target>) -> Option<LockedMove> {
        let locking = self.locking.as_ref()?;
        let every = n_samples.div_ceil(MAX_SAMPLES).max(1);
        let moves = (0..n_samples).step_by(every).filter_map(|row| {
            let targets = targets(row);
            let moved = locking.moved(targets.get(..self.drives.len())?, 1.0)?;
            (moved.tip_quadratic > TINY).then_some(moved)
        });
        moves.max_by(|a, b| a.tip_quadratic.total_cmp(&b.tip_quadratic))
    }
}

/// Reach of a run that moved the tip `reached` \[m\] at most, as ten-node tetrahedra would give it.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct RunLocking {
    /// Farthest that the tip was from rest [m].
    pub tip_m: f64,
    /// The same with ten-node tetrahedra, estimated [m].
    pub tip_ten_node_m: f64,
}

impl RunLocking {
    /// Scales what was predicted to the distance at which the tip is in `state`.
    pub fn new(predicted: &LockedMove, twin: &Twin, state: &TwinState) -> Self {
        let reached = distance(twin.tip_of(&twin.rest()), twin.tip_of(state));
        Self { tip_m: reached, tip_ten_node_m: reached * predicted.gain() }
    }
}
