//! Locking of linear tetrahedra on a robot, as verbs report it.

use hysteron_base::{PrescribedQuantity, Scene};
use hysteron_fem::{Cells, Mesh};
use hysteron_twin::{LockedMove, Locking, Target, Twin};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Share of stiffness, or of the tip's motion, above which a warning is logged [-]: below, friction and material are known
/// no better.
const CONSIDERABLE: f64 = 0.05;
/// Samples of a recording that are tried for the one that moves the tip farthest.
const MAX_SAMPLES: usize = 200;
/// How a mesh gets ten-node tetrahedra.
const TO_TEN_NODES: &str = "`hysteron mesh --quadratic`; or `printf 'Merge \"part.msh\"; SetOrder 2; Save \"part-2.msh\";' > \
                            order.geo`, then `gmsh order.geo -parse_and_exit`";
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
    Estimated(Vec<Comparison>),
}

/// The same command for linear and ten-node tetrahedra.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Comparison {
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

impl Comparison {
    fn new(command: String, moved: &LockedMove) -> Self {
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

/// Warns of what linear tetrahedra lose on the body of a scene, before something is fitted to it.
///
/// # Errors
/// Those of reading the mesh, and of the twin.
pub(crate) fn warn_before_fit(scene: &Scene) -> anyhow::Result<()> {
    let mesh = hysteron_fem::read_mesh(&scene.mesh_path, scene.mesh_unit.to_m())?;
    Estimator::new(scene, &mesh)?.warn();
    Ok(())
}

/// The two discretisations of a scene, where they can be compared.
pub struct Estimator {
    locking: Option<Locking>,
    estimate: LockingEstimate,
    drives: Vec<PrescribedQuantity>,
    names: Vec<String>,
}

impl Estimator {
    /// Factorises both discretisations.
    ///
    /// # Errors
    /// Those of the twin.
    pub fn new(scene: &Scene, mesh: &Mesh) -> anyhow::Result<Self> {
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
    fn compare_each(&self) -> Vec<Comparison> {
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
            found.extend(locking.moved(&targets, 0.0).map(|moved| Comparison::new(command, &moved)));
        }
        let loads = locking.moved(&free, 1.0).filter(|moved| moved.tip_quadratic > TINY);
        found.extend(loads.map(|moved| Comparison::new("weight and forces alone".to_owned(), &moved)));
        found
    }

    /// Locking estimate of the robot, for all its commands.
    pub fn estimate(&self) -> &LockingEstimate {
        &self.estimate
    }

    /// Warns of what every verb should know of the robot: the command that loses most.
    pub fn warn(&self) {
        match &self.estimate {
            LockingEstimate::TenNode => {}
            LockingEstimate::NotEstimated { nodes } => tracing::warn!(
                "linear tetrahedra, {nodes} nodes: their bending error is not estimated for so many; compare a \
                 coarser mesh with its ten-node tetrahedra ({TO_TEN_NODES})",
            ),
            LockingEstimate::Estimated(list) => {
                if let Some(worst) =
                    list.iter().max_by(|a, b| a.stiffness_ratio.total_cmp(&b.stiffness_ratio))
                {
                    warn_of(worst);
                }
            }
        }
    }

    /// The sample whose targets move the tip farthest, compared; warns of it. `targets` gives those of a sample.
    pub fn foresee(&self, n_samples: usize, targets: impl Fn(usize) -> Vec<Target>) -> Option<LockedMove> {
        let locking = self.locking.as_ref()?;
        let every = n_samples.div_ceil(MAX_SAMPLES).max(1);
        let moves = (0..n_samples).step_by(every).filter_map(|row| {
            let targets = targets(row);
            let moved = locking.moved(targets.get(..self.drives.len())?, 1.0)?;
            (moved.tip_quadratic > TINY).then_some(moved)
        });
        let farthest = moves.max_by(|a, b| a.tip_quadratic.total_cmp(&b.tip_quadratic))?;
        warn_of(&Comparison::new("this recording".to_owned(), &farthest));
        Some(farthest)
    }
}

/// Warns where a mesh is considerably too stiff.
fn warn_of(comparison: &Comparison) {
    let Comparison { command, tip_m, tip_ten_node_m, tension_n, tension_ten_node_n, stiffness_ratio, .. } =
        comparison;
    if *stiffness_ratio <= 1.0 + CONSIDERABLE {
        return;
    }
    let with = |tension: f64| match tension {
        0.0 => String::new(),
        tension => format!(" with {} N", digits(tension)),
    };
    tracing::warn!(
        "linear tetrahedra make this body {} times as stiff as ten-node tetrahedra: {command} moves the tip {} mm{}, \
         with ten nodes {} mm{} (first order, from rest; hint: {TO_TEN_NODES})",
        digits(*stiffness_ratio),
        digits(1e3 * tip_m),
        with(*tension_n),
        digits(1e3 * tip_ten_node_m),
        with(*tension_ten_node_n),
    );
}

/// Three significant digits.
fn digits(value: f64) -> String {
    let decimals = if value == 0.0 { 0 } else { (2 - value.abs().log10().floor() as i32).clamp(0, 9) };
    format!("{value:.*}", decimals as usize)
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
    /// Scales what was predicted to what came.
    pub fn new(predicted: &LockedMove, reached: f64) -> Self {
        Self { tip_m: reached, tip_ten_node_m: reached * predicted.gain() }
    }

    /// Warns where it is considerable.
    pub fn warn(&self) {
        if self.tip_m < (1.0 - CONSIDERABLE) * self.tip_ten_node_m {
            tracing::warn!(
                "the tip went {} mm from rest; with ten-node tetrahedra it would have gone about {} mm (linear tetrahedra \
                 make this body too stiff)",
                digits(1e3 * self.tip_m),
                digits(1e3 * self.tip_ten_node_m),
            );
        }
    }
}

/// Distance of the tip from rest [m].
pub fn tip_distance(twin: &Twin, state: &hysteron_twin::TwinState) -> f64 {
    let (rest, now) = (twin.tip_of(&twin.rest()), twin.tip_of(state));
    (0..3).map(|c| (now[c] - rest[c]).powi(2)).sum::<f64>().sqrt()
}
