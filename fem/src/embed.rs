//! Points carried by elements: cable nodes, loads and the tip.
//!
//! A point inside the body moves with the shape functions of its element. A point a little outside (in a
//! channel, or beyond a facet of a polygonal outline) is carried by the nearest element, whose
//! barycentric coordinates are then extrapolated: still exact for every affine motion. The coordinates
//! are those of the corners, so on a curved element the point is off by what the curvature adds.

use nalgebra::{Matrix3, Vector3};

use crate::elements::shape_values;
use crate::mesh::Cells;
use crate::model::FemModel;

/// A material point as a weighted sum of nodes.
#[derive(Debug, Clone, PartialEq)]
pub struct Embedding {
    /// Nodes in model order.
    pub nodes: Vec<u32>,
    /// Weight of each node; they add up to one.
    pub weights: Vec<f64>,
    /// Distance of the point from the body at rest [m]; zero inside.
    pub distance: f64,
}

impl Embedding {
    /// Finds the element that carries `point` [m] (rest configuration).
    pub fn new(model: &FemModel, point: [f64; 3]) -> Self {
        let target = Vector3::from(point);
        let mut best = (f64::INFINITY, 0);
        for e in 0..model.cells.len() {
            let corners = corners(model, e);
            let center = corners.iter().sum::<Vector3<f64>>() / 4.0;
            let reach = corners.iter().map(|c| (c - center).norm()).fold(0.0, f64::max);
            if (target - center).norm() - reach >= best.0 {
                continue;
            }
            let distance = distance_to(&corners, &target);
            if distance < best.0 {
                best = (distance, e);
            }
            if distance == 0.0 {
                break;
            }
        }
        let (distance, e) = best;
        let l = barycentric(&corners(model, e), &target);
        let weights = match &model.cells {
            Cells::Tet4(_) => shape_values::<4>(l).to_vec(),
            Cells::Tet10(_) => shape_values::<10>(l).to_vec(),
        };
        Self { nodes: model.cells.nodes(e).to_vec(), weights, distance }
    }

    /// Where the point is when the nodes are at `x` (model order).
    pub fn at(&self, x: &[[f64; 4]]) -> [f64; 3] {
        let mut point = [0.0; 3];
        for (node, weight) in self.nodes.iter().zip(&self.weights) {
            for c in 0..3 {
                point[c] += weight * x[*node as usize][c];
            }
        }
        point
    }
}

fn corners(model: &FemModel, e: usize) -> [Vector3<f64>; 4] {
    model.cells.corners(e).map(|node| {
        let [x, y, z, _] = model.rest[node as usize];
        Vector3::new(x, y, z)
    })
}

/// Barycentric coordinates; negative ones outside.
fn barycentric(corners: &[Vector3<f64>; 4], point: &Vector3<f64>) -> [f64; 4] {
    let edges =
        Matrix3::from_columns(&[corners[1] - corners[0], corners[2] - corners[0], corners[3] - corners[0]]);
    let l = edges.try_inverse().unwrap_or_else(Matrix3::zeros) * (point - corners[0]);
    [1.0 - l.sum(), l[0], l[1], l[2]]
}

/// Distance of a point from a tetrahedron, zero inside.
fn distance_to(corners: &[Vector3<f64>; 4], point: &Vector3<f64>) -> f64 {
    // Round-off in the position of a point on a face, relative to the element.
    const INSIDE: f64 = -1e-9;
    if barycentric(corners, point).iter().all(|&l| l >= INSIDE) {
        return 0.0;
    }
    const FACES: [[usize; 3]; 4] = [[1, 2, 3], [0, 2, 3], [0, 1, 3], [0, 1, 2]];
    let to_face = |face: [usize; 3]| distance_to_triangle(face.map(|i| corners[i]), point);
    FACES.into_iter().map(to_face).fold(f64::INFINITY, f64::min)
}

/// Distance of a point from a triangle: from its plane where the foot lies inside, else from its edges.
fn distance_to_triangle([a, b, c]: [Vector3<f64>; 3], point: &Vector3<f64>) -> f64 {
    let normal = (b - a).cross(&(c - a));
    let offset = point - a;
    let inside = [(a, b), (b, c), (c, a)]
        .into_iter()
        .all(|(from, to)| (to - from).cross(&(point - from)).dot(&normal) >= 0.0);
    if inside {
        return offset.dot(&normal).abs() / normal.norm();
    }
    [(a, b), (b, c), (c, a)]
        .into_iter()
        .map(|(from, to)| {
            let along = ((point - from).dot(&(to - from)) / (to - from).norm_squared()).clamp(0.0, 1.0);
            (point - from - along * (to - from)).norm()
        })
        .fold(f64::INFINITY, f64::min)
}
