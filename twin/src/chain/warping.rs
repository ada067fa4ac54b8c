//! How interfaces deform: the strongest warpings among linear responses of the body at rest.

use std::sync::Arc;

use hysteron_fem::{FactorKind, FemModel, Stiffness, StiffnessFactor, Tangent};
use nalgebra::{DMatrix, Matrix3, Vector3};

use super::WARPINGS;
use super::cut::{Cut, NodePlace};
use crate::Result;
use crate::model::Twin;

/// Weight of a tendon's tension against other unit loads [-]: the response to what mostly loads the body is in the basis.
const TENDON_WEIGHT: f64 = 1000.0;
/// The same of a force on the tip, by which contacts are found. More takes warpings from auxiliary tendons, less makes the tip
/// stiffer against a force by some percent.
const TIP_WEIGHT: f64 = 100.0;
/// Part of the strongest warping below which what is left of a response is round-off.
const ROUND_OFF: f64 = 1e-11;

/// An interface at rest.
#[derive(Debug, Clone)]
pub(crate) struct InterfaceShape {
    /// Its nodes, model order of the body.
    pub nodes: Vec<u32>,
    /// Their mean [m].
    pub center: Vector3<f64>,
    /// Displacement of each node per amplitude [-]: no rigid motion, root mean square one; zero beyond the rank of the
    /// responses.
    pub warpings: Vec<[Vector3<f64>; WARPINGS]>,
}

impl InterfaceShape {
    fn new(body: &FemModel, cut: &Cut, i: usize) -> Self {
        let on = |node: &u32| cut.places[*node as usize] == NodePlace::Interface(i);
        let nodes: Vec<u32> = (0..body.n_nodes() as u32).filter(on).collect();
        let center = nodes.iter().map(|&node| rest(body, node)).sum::<Vector3<f64>>() / nodes.len() as f64;
        Self { warpings: vec![[Vector3::zeros(); WARPINGS]; nodes.len()], center, nodes }
    }

    /// Sets the warpings to the strongest of `responses`, displacements of all free nodes [m].
    fn warp(&mut self, body: &FemModel, responses: &[Vec<f64>]) {
        let arms: Vec<Vector3<f64>> = self.nodes.iter().map(|&node| rest(body, node) - self.center).collect();
        let n = arms.len();
        let mut moved = DMatrix::zeros(3 * n, responses.len());
        for (k, response) in responses.iter().enumerate() {
            let at = |node: u32| Vector3::from_column_slice(&response[3 * node as usize..][..3]);
            let own: Vec<Vector3<f64>> = self.nodes.iter().map(|&node| at(node)).collect();
            for (i, warped) in without_rigid_motion(&arms, &own).into_iter().enumerate() {
                moved.fixed_view_mut::<3, 1>(3 * i, k).copy_from(&warped);
            }
        }
        let spectrum = (moved.transpose() * &moved).symmetric_eigen();
        let mut order: Vec<usize> = (0..responses.len()).collect();
        order.sort_by(|&a, &b| spectrum.eigenvalues[b].total_cmp(&spectrum.eigenvalues[a]));
        let ordered =
            moved * DMatrix::from_fn(order.len(), order.len(), |i, j| spectrum.eigenvectors[(i, order[j])]);
        let strongest = if order.is_empty() { 0.0 } else { ordered.column(0).norm() };
        let mut basis: Vec<nalgebra::DVector<f64>> = Vec::new();
        for column in ordered.column_iter() {
            // Eigenvectors of weak responses carry round-off of the strong ones: orthogonal once more, twice.
            let mut left = column.into_owned();
            for _ in 0..2 {
                for known in &basis {
                    left.axpy(-known.dot(&left), known, 1.0);
                }
            }
            if basis.len() < WARPINGS && left.norm() > ROUND_OFF * strongest {
                basis.push(left.normalize());
            }
        }
        for (k, warping) in basis.iter().enumerate() {
            for (i, of_node) in self.warpings.iter_mut().enumerate() {
                of_node[k] = (n as f64).sqrt() * warping.fixed_rows::<3>(3 * i);
            }
        }
    }
}

/// Rest position of a node [m].
pub(crate) fn rest(body: &FemModel, node: u32) -> Vector3<f64> {
    let [x, y, z, _] = body.rest[node as usize];
    Vector3::new(x, y, z)
}

/// Displacements less the rigid motion nearest to them, of points with these arms about their mean.
fn without_rigid_motion(arms: &[Vector3<f64>], moved: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
    let mean = moved.iter().sum::<Vector3<f64>>() / arms.len() as f64;
    let inertia: Matrix3<f64> =
        arms.iter().map(|r| Matrix3::from_diagonal_element(r.norm_squared()) - r * r.transpose()).sum();
    let moment: Vector3<f64> = arms.iter().zip(moved).map(|(r, u)| r.cross(u)).sum();
    let turn = inertia.try_inverse().unwrap_or_else(Matrix3::zeros) * moment;
    arms.iter().zip(moved).map(|(r, u)| u - mean - turn.cross(r)).collect()
}

/// All interfaces, the clamp first, with warpings from the responses to unit loads: forces on every tendon point and on the
/// tip, tensions, couples on the last interface, gravity.
///
/// # Errors
/// The rest stiffness has no factor.
pub(crate) fn interfaces(twin: &Twin, cut: &Cut) -> Result<Vec<InterfaceShape>> {
    let body = &twin.body;
    let mut interfaces: Vec<InterfaceShape> =
        (0..=cut.n_sections).map(|i| InterfaceShape::new(body, cut, i)).collect();
    let mut loads = unit_loads(twin);
    if let Some(last) = interfaces.last() {
        loads.extend(couples(body, last));
    }
    let responses = responses(body, loads)?;
    for interface in &mut interfaces[1..] {
        interface.warp(body, &responses);
    }
    Ok(interfaces)
}

/// Displacements of the free unknowns under `loads` at rest [m].
pub(crate) fn responses(body: &FemModel, mut loads: Vec<Vec<f64>>) -> Result<Vec<Vec<f64>>> {
    let pattern = Arc::new(body.stiffness_pattern(&[]));
    let mut factor = StiffnessFactor::new(&pattern, FactorKind::Supernodal, body.isa);
    let mut stiffness = Stiffness::zeros(pattern);
    body.stiffness_into(&body.rest, Tangent::Exact, &mut stiffness);
    factor.factorize(&stiffness)?;
    factor.solve_many(&mut loads);
    Ok(loads)
}

/// Forces on the free unknowns [N].
fn unit_loads(twin: &Twin) -> Vec<Vec<f64>> {
    let body = &twin.body;
    let mut loads = Vec::new();
    let mut add = |scale: f64, carriers: &mut dyn Iterator<Item = (u32, f64)>| {
        let carriers: Vec<(u32, f64)> = carriers.filter(|(node, _)| (*node as usize) < body.n_free).collect();
        if carriers.is_empty() {
            return;
        }
        for c in 0..3 {
            let mut load = vec![0.0; body.n_unknowns()];
            for &(node, weight) in &carriers {
                load[3 * node as usize + c] += scale * weight;
            }
            loads.push(load);
        }
    };
    for j in 0..twin.tendons.len() {
        for point in twin.cables.points_of(j) {
            add(1.0, &mut twin.cables.carriers(point).iter().copied());
        }
    }
    add(TIP_WEIGHT, &mut twin.tip.nodes.iter().copied().zip(twin.tip.weights.iter().copied()));
    let volume: f64 = body.nodal_volumes.iter().sum();
    add(1.0, &mut (0..).zip(body.nodal_volumes.iter().map(|own| own / volume)));
    let mut shape = twin.cables.shape();
    twin.cables.measure(&body.rest, &mut shape);
    for j in 0..twin.tendons.len() {
        let mut load = vec![0.0; body.n_unknowns()];
        twin.cables.row_into(&shape, j, &mut load);
        load.iter_mut().for_each(|force| *force *= TENDON_WEIGHT);
        loads.push(load);
    }
    loads
}

/// Couples about the three axes on the nodes of an interface, of one newton times its radius of inertia.
fn couples(body: &FemModel, interface: &InterfaceShape) -> [Vec<f64>; 3] {
    let arms: Vec<Vector3<f64>> =
        interface.nodes.iter().map(|&node| rest(body, node) - interface.center).collect();
    let inertia: f64 = arms.iter().map(Vector3::norm_squared).sum();
    let radius = (inertia / arms.len() as f64).sqrt();
    [0, 1, 2].map(|axis| {
        let mut load = vec![0.0; body.n_unknowns()];
        for (&node, arm) in interface.nodes.iter().zip(&arms) {
            let force = radius / inertia * Vector3::ith(axis, 1.0).cross(arm);
            load[3 * node as usize..][..3].copy_from_slice(force.as_slice());
        }
        load
    })
}
