//! Numbering of the free nodes.
//!
//! The model keeps its nodes in the order in which a factorisation eliminates them, so that no kernel
//! ever permutes. Candidates are reverse Cuthill-McKee, the projection on the longest axis of the body, and that on
//! axes a little tilted, which sweep every layer of nodes from side to side; the one with the cheapest block envelope
//! wins. faer's supernodal factorisation keeps it or reorders by minimum degree,
//! whichever is faster.

use sprs::{CsMatI, TriMatI};

use crate::mesh::Cells;
use crate::simd::BlockEnvelope;

/// Neighbour lists of the nodes: which share an element. Symmetric, with the diagonal.
pub(crate) fn adjacency(n_nodes: usize, cliques: impl Iterator<Item = Vec<u32>>) -> CsMatI<u8, u32, u32> {
    let mut triplets = TriMatI::<u8, u32>::new((n_nodes, n_nodes));
    for node in 0..n_nodes {
        triplets.add_triplet(node, node, 0);
    }
    for clique in cliques {
        for &a in &clique {
            for &b in &clique {
                triplets.add_triplet(a as usize, b as usize, 0);
            }
        }
    }
    triplets.to_csr()
}

/// Slopes of the axes tried, towards the second and third longest direction: so small that layers stay apart.
const TILTS: [[f64; 2]; 5] = [[0.0, 0.0], [0.01, 0.0], [-0.01, 0.0], [0.0, 0.01], [0.0, -0.01]];

/// File nodes in model order: free ones as they are eliminated, then the clamped ones.
pub(crate) fn model_order(nodes: &[[f64; 3]], cells: &Cells, clamped: &[bool]) -> Vec<u32> {
    let free: Vec<u32> = (0..nodes.len() as u32).filter(|&i| !clamped[i as usize]).collect();
    let mut number = vec![u32::MAX; nodes.len()];
    for (k, &node) in free.iter().enumerate() {
        number[node as usize] = k as u32;
    }
    let cliques = (0..cells.len()).map(|e| {
        let nodes = cells.nodes(e).iter().map(|&node| number[node as usize]);
        nodes.filter(|&k| k != u32::MAX).collect()
    });
    let graph = adjacency(free.len(), cliques);
    let mckee = sprs::linalg::reverse_cuthill_mckee(graph.view()).perm.vec();
    let best = orders_along(nodes, &free)
        .into_iter()
        .chain([mckee])
        .min_by(|a, b| envelope_cost(&graph, a).total_cmp(&envelope_cost(&graph, b)))
        .unwrap_or_default();
    let clamped = (0..nodes.len() as u32).filter(|&i| clamped[i as usize]);
    best.into_iter().map(|k| free[k as usize]).chain(clamped).collect()
}

/// First column of every row of the lower triangle, three unknowns a node.
pub(crate) fn first_columns(graph: &CsMatI<u8, u32, u32>, order: &[u32]) -> Vec<usize> {
    let mut position = vec![0; order.len()];
    for (k, &node) in order.iter().enumerate() {
        position[node as usize] = k;
    }
    let first_node = |node: u32| {
        let neighbours = graph.outer_view(node as usize);
        let before = neighbours.iter().flat_map(|row| row.indices()).map(|&b| position[b as usize]);
        before.min().unwrap_or(0).min(position[node as usize])
    };
    order.iter().flat_map(|&node| [3 * first_node(node); 3]).collect()
}

fn envelope_cost(graph: &CsMatI<u8, u32, u32>, order: &[u32]) -> f64 {
    BlockEnvelope::factor_cost(&first_columns(graph, order))
}

/// Indices into `free`, sorted along the direction in which the body is longest, with every one of the [`TILTS`].
fn orders_along(nodes: &[[f64; 3]], free: &[u32]) -> [Vec<u32>; TILTS.len()] {
    let points: Vec<_> = free.iter().map(|&i| nalgebra::Vector3::from(nodes[i as usize])).collect();
    let mean = points.iter().sum::<nalgebra::Vector3<f64>>() / points.len().max(1) as f64;
    let mut covariance = nalgebra::Matrix3::zeros();
    for point in &points {
        covariance += (point - mean) * (point - mean).transpose();
    }
    let eigen = covariance.symmetric_eigen();
    let mut by_length = [0, 1, 2];
    by_length.sort_by(|&a, &b| eigen.eigenvalues[b].total_cmp(&eigen.eigenvalues[a]));
    let [longest, second, third] = by_length.map(|k| eigen.eigenvectors.column(k));
    TILTS.map(|tilt| {
        let axis = longest + tilt[0] * second + tilt[1] * third;
        let along: Vec<f64> = points.iter().map(|point| axis.dot(point)).collect();
        let mut order: Vec<u32> = (0..free.len() as u32).collect();
        order.sort_by(|&a, &b| along[a as usize].total_cmp(&along[b as usize]).then(a.cmp(&b)));
        order
    })
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;
    use std::f64::consts::FRAC_PI_2;

    use super::*;
    use crate::{Layers, Mesh, Order, TendonChannel, Tube};

    fn rod() -> Mesh {
        let tube = Tube {
            profile: vec![[0.0, 0.01], [0.2, 0.01]],
            bore_radius: 0.0,
            channels: Vec::new(),
            outer_divisions: 8,
            bore_divisions: 0,
            channel_divisions: 0,
            layers: Layers::Count(30),
            order: Order::Linear,
        };
        tube.mesh().expect("a mesh")
    }

    fn tube() -> Mesh {
        let tube = Tube {
            profile: vec![[0.0, 0.006], [0.08, 0.006]],
            bore_radius: 0.003,
            channels: (0..4)
                .map(|k| TendonChannel {
                    angle: f64::from(k) * FRAC_PI_2,
                    center_radius: 4.5e-3,
                    radius: 0.75e-3,
                })
                .collect(),
            outer_divisions: 16,
            bore_divisions: 8,
            channel_divisions: 4,
            layers: Layers::Count(17),
            order: Order::Linear,
        };
        tube.mesh().expect("a mesh")
    }

    /// The rod coiled like a spring: no axis sorts it.
    fn spring() -> Mesh {
        let mut mesh = rod();
        for x in &mut mesh.nodes {
            let (sin, cos) = (30.0 * x[2]).sin_cos();
            *x = [(0.05 + x[0]) * cos, (0.05 + x[0]) * sin, x[1] + 0.1 * x[2]];
        }
        mesh
    }

    /// Costs of the chosen order, of those along the axes, and of reverse Cuthill-McKee.
    fn costs(mesh: &Mesh) -> (f64, [f64; TILTS.len()], f64) {
        let clamped: Vec<bool> =
            (0..mesh.nodes.len() as u32).map(|i| mesh.groups["base"].contains(&i)).collect();
        let order = model_order(&mesh.nodes, &mesh.cells, &clamped);
        let free: Vec<u32> = (0..mesh.nodes.len() as u32).filter(|&i| !clamped[i as usize]).collect();
        let number = |node: u32| free.iter().position(|&i| i == node).map(|k| k as u32);
        let cliques = (0..mesh.cells.len())
            .map(|e| mesh.cells.nodes(e).iter().filter_map(|&node| number(node)).collect());
        let graph = adjacency(free.len(), cliques);
        let chosen: Vec<u32> = order[..free.len()].iter().map(|&node| number(node).expect("free")).collect();
        let mckee = sprs::linalg::reverse_cuthill_mckee(graph.view()).perm.vec();
        let along = orders_along(&mesh.nodes, &free).map(|order| envelope_cost(&graph, &order));
        (envelope_cost(&graph, &chosen), along, envelope_cost(&graph, &mckee))
    }

    #[test]
    fn cheapest_order_is_taken() {
        let cheapest = |costs: &[f64]| costs.iter().copied().fold(f64::INFINITY, f64::min);
        let (chosen, along, mckee) = costs(&spring());
        assert!(mckee < 0.5 * cheapest(&along), "{along:?} {mckee}");
        assert_eq!(chosen, mckee);
        let (chosen, along, mckee) = costs(&rod());
        assert!(cheapest(&along) < mckee, "{along:?} {mckee}");
        assert_eq!(chosen, cheapest(&along));
        // A tube whose nodes are numbered from channel to channel: a sweep is better than the numbers.
        let (chosen, [axis, tilted @ ..], mckee) = costs(&tube());
        assert!(cheapest(&tilted) < axis && cheapest(&tilted) < mckee, "{axis} {tilted:?} {mckee}");
        assert_eq!(chosen, cheapest(&tilted));
    }

    #[test]
    fn every_node_is_ordered_once_and_clamped_ones_come_last() {
        let mesh = rod();
        let clamped: Vec<bool> = (0..mesh.nodes.len()).map(|i| i % 7 == 3).collect();
        let order = model_order(&mesh.nodes, &mesh.cells, &clamped);
        let all: BTreeSet<u32> = order.iter().copied().collect();
        assert_eq!((all.len(), order.len()), (mesh.nodes.len(), mesh.nodes.len()));
        let n_free = clamped.iter().filter(|c| !**c).count();
        assert!(order[..n_free].iter().all(|&i| !clamped[i as usize]));
        assert!(order[n_free..].is_sorted());
    }
}
