//! Element data in batches of eight, laid out as the kernels read it.

use super::shape::{quadrature, shape_derivatives, shape_values};
use crate::simd::{LANES, Pack};

/// One quadrature point of the eight elements of a batch.
#[derive(Debug, Clone)]
pub(crate) struct PointData<const N: usize> {
    /// Rest volume of the point times the element's stiffness over the material's \[m³\]; zero in lanes that only fill up the
    /// last batch.
    pub weight: Pack,
    /// Rest gradients of the shape functions \[1/m\]. Node 0 is implied: the gradients add up to zero.
    pub gradients: [[Pack; 3]; N],
}

/// All elements of a model, `N` nodes and `Q` quadrature points each.
#[derive(Debug, Clone)]
pub(crate) struct ElementBatch<const N: usize, const Q: usize> {
    /// Nodes in the model's order, per batch.
    pub nodes: Vec<[[u32; LANES]; N]>,
    /// Per batch.
    pub points: Vec<[PointData<N>; Q]>,
}

/// Where every node pair (a >= b) of every element adds its 3×3 block, or [`PairMap::SKIP`].
#[derive(Debug, Clone)]
pub(crate) struct PairMap {
    /// Pairs (0,0), (1,0), (1,1), (2,0), … of batch 0, then of batch 1, …; per lane.
    pub slots: Vec<[u32; LANES]>,
}

impl PairMap {
    /// A clamped node: nothing to add.
    pub const SKIP: u32 = u32::MAX;
    /// Set where the pair is transposed: the row node has the lower number.
    pub const TRANSPOSED: u32 = 1 << 31;
}

impl<const N: usize, const Q: usize> ElementBatch<N, Q> {
    /// Lays out elements given by their nodes (model order) at rest positions `rest`.
    pub fn new(cells: &[[u32; N]], rest: &[[f64; 4]]) -> Self {
        let n_batches = cells.len().div_ceil(LANES);
        let mut nodes = vec![[[0; LANES]; N]; n_batches];
        let blank = PointData { weight: Pack([0.0; LANES]), gradients: [[Pack([0.0; LANES]); 3]; N] };
        let mut points = vec![std::array::from_fn(|_| blank.clone()); n_batches];
        for slot in 0..n_batches * LANES {
            let (batch, lane) = (slot / LANES, slot % LANES);
            let cell = &cells[slot.min(cells.len() - 1)];
            for a in 0..N {
                nodes[batch][a][lane] = cell[a];
            }
            let corners: [[f64; 4]; N] = cell.map(|node| rest[node as usize]);
            for (point, l) in points[batch].iter_mut().zip(quadrature::<Q>()) {
                let (weight, gradients) = gradients_at(&corners, l);
                point.weight.0[lane] = if slot < cells.len() { weight / Q as f64 } else { 0.0 };
                for a in 0..N {
                    for c in 0..3 {
                        point.gradients[a][c].0[lane] = gradients[a][c];
                    }
                }
            }
        }
        Self { nodes, points }
    }

    /// Makes each element stiffer by a factor \[-\].
    pub fn stiffen(&mut self, factors: &[f64]) {
        for (slot, factor) in factors.iter().enumerate() {
            for point in &mut self.points[slot / LANES] {
                point.weight.0[slot % LANES] *= factor;
            }
        }
    }

    /// Rest volume of every node, ∫ N_a dV \[m³\]: times density and gravity it is the nodal weight. Before elements are
    /// stiffened.
    pub fn nodal_volumes(&self, n_nodes: usize) -> Vec<f64> {
        let mut volumes = vec![0.0; n_nodes];
        for (nodes, points) in self.nodes.iter().zip(&self.points) {
            for (point, l) in points.iter().zip(quadrature::<Q>()) {
                let values = shape_values::<N>(l);
                for a in 0..N {
                    for lane in 0..LANES {
                        volumes[nodes[a][lane] as usize] += point.weight.0[lane] * values[a];
                    }
                }
            }
        }
        volumes
    }
}

/// The first of `cells` with det F <= 0 in a quadrature point at positions `x`, and that determinant.
pub(crate) fn first_inverted<const N: usize, const Q: usize>(
    cells: &[[u32; N]],
    rest: &[[f64; 4]],
    x: &[[f64; 4]],
) -> Option<(usize, f64)> {
    let least = |cell: &[u32; N]| {
        let corners: [[f64; 4]; N] = cell.map(|node| rest[node as usize]);
        let determinant = |l| {
            let (_, gradients) = gradients_at(&corners, l);
            let mut f = nalgebra::Matrix3::<f64>::zeros();
            for (node, gradient) in cell.iter().zip(gradients) {
                let [a, b, c, _] = x[*node as usize];
                f += nalgebra::Vector3::new(a, b, c) * nalgebra::RowVector3::from(gradient);
            }
            f.determinant()
        };
        quadrature::<Q>().into_iter().map(determinant).fold(f64::INFINITY, f64::min)
    };
    cells.iter().map(least).enumerate().find(|(_, determinant)| *determinant <= 0.0)
}

/// Element volume density and rest gradients of the shape functions at barycentric `l`.
fn gradients_at<const N: usize>(corners: &[[f64; 4]; N], l: [f64; 4]) -> (f64, [[f64; 3]; N]) {
    let by_barycentric = shape_derivatives::<N>(l);
    // Columns of the Jacobian: dX / dl_k - dX / dl_0 for k = 1, 2, 3.
    let mut jacobian = nalgebra::Matrix3::<f64>::zeros();
    for a in 0..N {
        for k in 0..3 {
            let along = by_barycentric[a][k + 1] - by_barycentric[a][0];
            for c in 0..3 {
                jacobian[(c, k)] += corners[a][c] * along;
            }
        }
    }
    let volume = jacobian.determinant() / 6.0;
    let inverse = jacobian.try_inverse().unwrap_or_else(nalgebra::Matrix3::zeros);
    let gradients = std::array::from_fn(|a| {
        std::array::from_fn(|c| {
            (0..3).map(|k| (by_barycentric[a][k + 1] - by_barycentric[a][0]) * inverse[(k, c)]).sum()
        })
    });
    (volume.abs(), gradients)
}
