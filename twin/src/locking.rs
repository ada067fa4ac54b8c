//! Locking of linear tetrahedra on a body: its response at rest to its own tendons and loads, compared with
//! that of ten-node tetrahedra of the same mesh.
//!
//! Linear tetrahedra are too stiff in bending where few lie across a wall, and near ν = 1/2 in every deformation but
//! pure shear. How much depends on body, mesh, material and load together, and no count of elements gives it.
//! So both discretisations are computed: the same tetrahedra with a node at the middle of every edge
//! represent bending exactly and hardly lock, and at rest all laws are linear, so that one factorisation each
//! is enough. The effect of large bends is neglected.

use std::sync::Arc;

use hysteron_base::{MaterialLaw, Scene};
use hysteron_fem::{Cells, FactorKind, Mesh, Stiffness, StiffnessFactor, Tangent};
use hysteron_fit::qp::{BoxQp, QpStatus};

use crate::Result;
use crate::equilibrium_residual::StepTargets;
use crate::model::{Target, Twin};
use crate::projection::Projection;

/// Nodes of a linear mesh above which no estimate is made: it would have some 100 000 unknowns, a factor of 1 GB, and
/// take longer than many runs.
const MAX_NODES: usize = 4500;

/// The same body twice: as it is meshed, and with ten-node tetrahedra.
#[derive(Debug, Clone)]
pub struct Locking {
    linear: RestResponse,
    quadratic: RestResponse,
}

/// How far the tip goes and what it takes, with linear and with ten-node tetrahedra.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LockedMove {
    /// Distance of the tip from rest with the mesh as it is [m].
    pub tip: f64,
    /// The same with ten-node tetrahedra [m].
    pub tip_quadratic: f64,
    /// Largest tension with the mesh as it is [N].
    pub tension: f64,
    /// The same with ten-node tetrahedra [N].
    pub tension_quadratic: f64,
}

impl LockedMove {
    /// Share of the tip's motion that the mesh loses [-]; negative where it moves farther.
    pub fn loss(&self) -> f64 {
        if self.tip_quadratic > 0.0 { 1.0 - self.tip / self.tip_quadratic } else { 0.0 }
    }

    /// How many times farther the tip goes with ten-node tetrahedra [-]; one where it does not move.
    pub fn gain(&self) -> f64 {
        if self.tip > 0.0 { self.tip_quadratic / self.tip } else { 1.0 }
    }
}

impl Locking {
    /// Compares the two for the body, tendons and loads of `scene`, without auxiliary tendons and friction. `None` where
    /// the mesh has ten-node tetrahedra already, or more nodes than an estimate is worth.
    ///
    /// # Errors
    /// As [`Twin::new`]; a body without stiffness.
    pub fn new(scene: &Scene, mesh: &Mesh) -> Result<Option<Self>> {
        if matches!(mesh.cells, Cells::Tet10(_)) || mesh.nodes.len() > MAX_NODES {
            return Ok(None);
        }
        let mut bare = Scene { auxiliary: None, friction: None, ..scene.clone() };
        // The frame of the edges is for linear elements only; at rest it makes no difference.
        if bare.material.law == MaterialLaw::CorotationalEdges {
            bare.material.law = MaterialLaw::Corotational;
        }
        let linear = RestResponse::new(Twin::new(&bare, mesh)?)?;
        let quadratic = RestResponse::new(Twin::new(&bare, &mesh.to_quadratic())?)?;
        Ok(Some(Self { linear, quadratic }))
    }

    /// Response of both discretisations to the targets (one per primary tendon) and the part `load` of weight
    /// and forces, to first order. `None` where tensions cannot be found.
    pub fn moved(&self, targets: &[Target], load: f64) -> Option<LockedMove> {
        let (tip, tension) = self.linear.moved(targets, load)?;
        let (tip_quadratic, tension_quadratic) = self.quadratic.moved(targets, load)?;
        Some(LockedMove { tip, tip_quadratic, tension, tension_quadratic })
    }
}

/// The linear response of one discretisation at rest.
#[derive(Debug, Clone)]
struct RestResponse {
    twin: Twin,
    projection: Projection,
    /// Displacement of the tip per tension, three rows [m/N].
    tip_rows: [Vec<f64>; 3],
    /// Displacement of the tip under all loads [m].
    tip_under_load: [f64; 3],
    /// Strokes under all loads, the tendons slack [m].
    strokes_under_load: Vec<f64>,
}

impl RestResponse {
    fn new(twin: Twin) -> Result<Self> {
        let pattern = Arc::new(twin.body.stiffness_pattern(&[]));
        let mut factor = StiffnessFactor::new(&pattern, FactorKind::Supernodal, twin.body.isa);
        let mut stiffness = Stiffness::zeros(pattern);
        twin.body.stiffness_into(&twin.body.rest, Tangent::Warped, &mut stiffness);
        factor.factorize(&stiffness)?;
        let mut shape = twin.cables.shape();
        twin.cables.measure(&twin.body.rest, &mut shape);
        let mut projection = Projection::new(twin.body.n_unknowns(), twin.cables.len());
        projection.update(&twin.cables, &shape, &mut factor);
        let free = twin.loads.iter().take(twin.body.n_free);
        let mut moved: Vec<f64> = free.flat_map(|load| load[..3].to_vec()).collect();
        factor.solve(&mut moved);
        let tip = twin.tip_displacements([&moved, &moved, &moved]);
        let strokes = (0..twin.cables.len()).map(|j| twin.cables.row_times(&shape, j, &moved)).collect();
        Ok(Self {
            tip_rows: twin.tip_displacement_rows(&projection),
            tip_under_load: [0, 1, 2].map(|c| tip[c][0]),
            strokes_under_load: strokes,
            projection,
            twin,
        })
    }

    /// Distance of the tip from rest [m], and the largest tension [N].
    fn moved(&self, targets: &[Target], load: f64) -> Option<(f64, f64)> {
        let control = StepTargets::new(&self.twin, targets);
        let n = control.strokes.len();
        let missing: Vec<f64> =
            (0..n).map(|j| control.strokes[j] - load * self.strokes_under_load[j]).collect();
        let mut tensions = vec![0.0; n];
        if n > 0 {
            let mut qp = BoxQp::new(n);
            qp.set_matrix(&self.projection.delassus);
            let (status, _) = qp.solve(&missing, &control.lower, &control.upper, &mut tensions);
            if status != QpStatus::Solved {
                return None;
            }
        }
        let along = |c: usize| {
            let by_tension: f64 = self.tip_rows[c].iter().zip(&tensions).map(|(row, t)| row * t).sum();
            load * self.tip_under_load[c] + by_tension
        };
        let tip = (0..3).map(|c| along(c).powi(2)).sum::<f64>().sqrt();
        Some((tip, tensions.iter().fold(0.0, |max, t| t.abs().max(max))))
    }
}
