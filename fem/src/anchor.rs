//! Anchors: points that act on a part of the body instead of on one place.
//!
//! A force on a node, along a line or on one element sinks in without limit as the mesh is refined. An anchor spreads it
//! with a smooth weight φ of compact support, so that displacements at the anchor have a limit: P = Σ m_a x_a / Σ m_a with
//! m_a = ∫ N_a φ dV, φ = (1 - r²/R²)² within the radius R and zero beyond.
//!
//! Main decision: where the support is cut off by the surface of the body, φ is multiplied by 1 + b·(x - x̄) with b across
//! the anchor's direction, so that P lies on the line through its point in that direction. It is how a rigid insert passes on an
//! eccentric force, and keeps the lever arm of a tendon on every mesh. Along the line P lies where the material is.

use std::collections::BTreeMap;

use nalgebra::{Matrix2, Matrix4, Vector2, Vector3, Vector4};

use crate::elements::{shape_derivatives, shape_values};
use crate::mesh::Cells;
use crate::{Embedding, FemModel};

/// Two unit vectors across a unit vector and each other.
pub fn axes_across(along: &Vector3<f64>) -> [Vector3<f64>; 2] {
    let least = Vector3::ith(along.iamin(), 1.0);
    let across = along.cross(&least).normalize();
    [across, along.cross(&across)]
}

/// A part of the body that acts as one point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Anchor {
    /// The point at rest [m], in the body or next to it.
    pub center: [f64; 3],
    /// Radius R of the support [m], > 0.
    pub radius: f64,
    /// Direction in which the point may slide to where the material is; of any length but zero.
    pub along: [f64; 3],
}

/// The nodes that carry an anchor.
#[derive(Debug, Clone, PartialEq)]
pub struct AnchorCarriers {
    /// Nodes and weights; `distance` is zero.
    pub embedding: Embedding,
    /// ∫ φ dV over the body [m³].
    pub volume: f64,
}

impl Anchor {
    /// ∫ φ dV of an anchor that lies wholly inside the body [m³]: 32 π R³ / 105.
    pub fn whole_volume(&self) -> f64 {
        32.0 * std::f64::consts::PI / 105.0 * self.radius.powi(3)
    }

    /// The nodes of `model` that carry the anchor; `None` where no part of the body lies within the radius, or only
    /// parts in one plane with its direction.
    pub fn carriers(&self, model: &FemModel) -> Option<AnchorCarriers> {
        let mut moments = BumpMoments::new(self, model.n_nodes());
        match &model.cells {
            Cells::Tet4(cells) => moments.add_elements::<4>(cells, &model.rest),
            Cells::Tet10(cells) => moments.add_elements::<10>(cells, &model.rest),
        }
        moments.carriers()
    }
}

impl AnchorCarriers {
    /// Fewer nodes that stand for all: one in each cube of edge `spacing` \[m\], with the weights of the others there, all
    /// corrected so that their sum and their center stay. For stiffness matrices, where each node of an anchor is
    /// coupled with every other.
    pub fn thinned(&self, model: &FemModel, spacing: f64) -> Embedding {
        let point = Vector3::from(self.embedding.at(&model.rest));
        let mut cubes: BTreeMap<[i64; 3], Vec<Carrier>> = BTreeMap::new();
        for (&node, &weight) in self.embedding.nodes.iter().zip(&self.embedding.weights) {
            let arm = position(&model.rest, node) - point;
            let cube = [0, 1, 2].map(|c| (arm[c] / spacing).floor() as i64);
            cubes.entry(cube).or_default().push(Carrier { node, weight, arm });
        }
        let kept: Vec<Carrier> = cubes.values().filter_map(|cube| representative(cube)).collect();
        let row = |arm: &Vector3<f64>| Vector4::new(1.0, arm.x / spacing, arm.y / spacing, arm.z / spacing);
        let mut normal = Matrix4::zeros();
        let mut missing = Vector4::x();
        for Carrier { weight, arm, .. } in &kept {
            normal += weight.abs() * row(arm) * row(arm).transpose();
            missing -= *weight * row(arm);
        }
        // Where the kept nodes lie in a plane there is nothing to correct across it.
        let correction = normal.svd(true, true).solve(&missing, FLAT).unwrap_or_else(|_| Vector4::zeros());
        let (nodes, weights) = kept
            .iter()
            .map(|one| (one.node, one.weight + one.weight.abs() * correction.dot(&row(&one.arm))))
            .unzip();
        Embedding { nodes, weights, distance: 0.0 }
    }
}

/// Singular values below it are those of nodes in a plane [-].
const FLAT: f64 = 1e-9;

/// A node that carries an anchor.
struct Carrier {
    node: u32,
    weight: f64,
    /// From the anchor's center of weights to the node [m].
    arm: Vector3<f64>,
}

/// The node of a cube nearest to the center of its weights, with all of them.
fn representative(cube: &[Carrier]) -> Option<Carrier> {
    let size: f64 = cube.iter().map(|one| one.weight.abs()).sum();
    let center: Vector3<f64> = cube.iter().map(|one| one.weight.abs() / size * one.arm).sum();
    let away = |one: &&Carrier| (one.arm - center).norm_squared();
    let nearest = cube.iter().min_by(|a, b| away(a).total_cmp(&away(b)))?;
    let weight = cube.iter().map(|one| one.weight).sum();
    Some(Carrier { node: nearest.node, weight, arm: nearest.arm })
}

/// Longest reach of a part of an element that is integrated by one quadrature rule, over R [-]: ∫ φ of a whole anchor is
/// then right within some 1e-4.
const PART: f64 = 0.2;

/// Four-point rule of degree 2 (Keast 1986, rule 1), as barycentric coordinates.
const FAR: f64 = 0.138_196_601_125_010_5;

/// ∫ N_a φ dV and ∫ N_a φ y dV of every node, with y the two coordinates across the anchor.
struct BumpMoments<'a> {
    anchor: &'a Anchor,
    center: Vector3<f64>,
    /// Unit vectors across the anchor.
    across: [Vector3<f64>; 2],
    volume: Vec<f64>,
    first: Vec<Vector2<f64>>,
    /// ∫ φ y yᵀ dV.
    second: Matrix2<f64>,
}

impl<'a> BumpMoments<'a> {
    fn new(anchor: &'a Anchor, n_nodes: usize) -> Self {
        let along = Vector3::from(anchor.along).normalize();
        Self {
            anchor,
            center: anchor.center.into(),
            across: axes_across(&along),
            volume: vec![0.0; n_nodes],
            first: vec![Vector2::zeros(); n_nodes],
            second: Matrix2::zeros(),
        }
    }

    fn add_elements<const N: usize>(&mut self, cells: &[[u32; N]], rest: &[[f64; 4]]) {
        for cell in cells {
            let element = AnchorElement { nodes: cell, positions: cell.map(|node| position(rest, node)) };
            let corners = std::array::from_fn(|i| std::array::from_fn(|j| f64::from(u8::from(i == j))));
            self.add_part(&element, &corners);
        }
    }

    /// Adds the part of an element between four points, given by barycentric coordinates; cut in eight while it is large.
    fn add_part<const N: usize>(&mut self, element: &AnchorElement<N>, part: &[[f64; 4]; 4]) {
        let corners = part.map(|l| element.at(l));
        let middle = corners.iter().sum::<Vector3<f64>>() / 4.0;
        let reach = corners.iter().map(|corner| (corner - middle).norm()).fold(0.0, f64::max);
        // Curved edges lie a little beyond the straight ones.
        if (middle - self.center).norm() > self.anchor.radius + 1.25 * reach {
            return;
        }
        if reach > PART * self.anchor.radius {
            for piece in eighths(part) {
                self.add_part(element, &piece);
            }
            return;
        }
        for q in 0..4 {
            let l: [f64; 4] = std::array::from_fn(|c| {
                (0..4).map(|i| if i == q { 1.0 - 3.0 * FAR } else { FAR } * part[i][c]).sum()
            });
            self.add_point(element, l, 0.25 * share(part) * element.volume_density(l));
        }
    }

    fn add_point<const N: usize>(&mut self, element: &AnchorElement<N>, l: [f64; 4], volume: f64) {
        let arm = element.at(l) - self.center;
        let inside = 1.0 - arm.norm_squared() / self.anchor.radius.powi(2);
        if inside <= 0.0 {
            return;
        }
        let weight = inside * inside * volume;
        let y = Vector2::new(self.across[0].dot(&arm), self.across[1].dot(&arm));
        self.second += weight * y * y.transpose();
        for (node, value) in element.nodes.iter().zip(shape_values::<N>(l)) {
            self.volume[*node as usize] += value * weight;
            self.first[*node as usize] += value * weight * y;
        }
    }

    fn carriers(&self) -> Option<AnchorCarriers> {
        let volume: f64 = self.volume.iter().sum();
        if volume <= 0.0 {
            return None;
        }
        let mean = self.first.iter().sum::<Vector2<f64>>() / volume;
        let spread = self.second / volume - mean * mean.transpose();
        let tilt = spread.try_inverse()? * -mean;
        let level = 1.0 - tilt.dot(&mean);
        let weights = self.volume.iter().zip(&self.first).map(|(m, y)| (level * m + tilt.dot(y)) / volume);
        let (nodes, weights) = (0..).zip(weights).filter(|(_, weight)| *weight != 0.0).unzip();
        Some(AnchorCarriers { embedding: Embedding { nodes, weights, distance: 0.0 }, volume })
    }
}

struct AnchorElement<'a, const N: usize> {
    nodes: &'a [u32; N],
    positions: [Vector3<f64>; N],
}

impl<const N: usize> AnchorElement<'_, N> {
    fn at(&self, l: [f64; 4]) -> Vector3<f64> {
        self.positions.iter().zip(shape_values::<N>(l)).map(|(x, value)| value * x).sum()
    }

    /// Volume of the element if all of it were deformed as at `l` [m³].
    fn volume_density(&self, l: [f64; 4]) -> f64 {
        let by_barycentric = shape_derivatives::<N>(l);
        let edge = |k: usize| -> Vector3<f64> {
            self.positions.iter().zip(&by_barycentric).map(|(x, d)| (d[k] - d[0]) * x).sum()
        };
        (edge(1).cross(&edge(2)).dot(&edge(3)) / 6.0).abs()
    }
}

fn position(rest: &[[f64; 4]], node: u32) -> Vector3<f64> {
    let [x, y, z, _] = rest[node as usize];
    Vector3::new(x, y, z)
}

/// Share of the element between four points given by barycentric coordinates [-].
fn share(part: &[[f64; 4]; 4]) -> f64 {
    let edge = |i: usize| {
        Vector3::new(part[i][1], part[i][2], part[i][3]) - Vector3::new(part[0][1], part[0][2], part[0][3])
    };
    edge(1).cross(&edge(2)).dot(&edge(3)).abs()
}

/// A tetrahedron cut in eight of equal volume, the octahedron inside along one of its diagonals.
fn eighths([a, b, c, d]: &[[f64; 4]; 4]) -> [[[f64; 4]; 4]; 8] {
    let middle = |p: &[f64; 4], q: &[f64; 4]| -> [f64; 4] { std::array::from_fn(|k| 0.5 * (p[k] + q[k])) };
    let [ab, ac, ad] = [middle(a, b), middle(a, c), middle(a, d)];
    let [bc, bd, cd] = [middle(b, c), middle(b, d), middle(c, d)];
    [
        [*a, ab, ac, ad],
        [ab, *b, bc, bd],
        [ac, bc, *c, cd],
        [ad, bd, cd, *d],
        [ab, cd, ac, ad],
        [ab, cd, ad, bd],
        [ab, cd, bd, bc],
        [ab, cd, bc, ac],
    ]
}
