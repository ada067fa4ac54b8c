//! Tendons as cables through points of the body.
//!
//! A cable is a frictionless polyline; its tension T is the same along it. Its *stroke* is how much it
//! has been shortened, s(x) = L(rest) - L(x), so that a tension does the work T ds on the body, the rows
//! J = ∂s/∂x map tensions to nodal forces Jᵀ T, and T ∂²L/∂x² adds to the stiffness.

use hysteron_fem::{Embedding, FemModel, Stiffness, StiffnessPattern};

/// All cables of a robot, primary ones first. Never changes.
#[derive(Debug, Clone)]
pub struct Cables {
    /// First point of each cable, and one past the last point.
    starts: Vec<usize>,
    /// Points in order along each cable.
    points: Vec<Carried>,
    /// Rest length of each cable [m].
    pub rest_lengths: Vec<f64>,
}

/// A cable point: the nodes that carry it, with weights.
#[derive(Debug, Clone)]
struct Carried(Vec<(u32, f64)>);

/// Unit direction of every segment and length of every cable at some positions; scratch.
#[derive(Debug, Clone)]
pub(crate) struct CableShape {
    /// ∂s/∂P of each cable point.
    gradients: Vec<[f64; 3]>,
    /// Position of each cable point [m].
    positions: Vec<[f64; 3]>,
    /// Stroke of each cable [m].
    pub strokes: Vec<f64>,
}

impl Cables {
    /// Cables through embedded points, at least two each.
    pub fn new(model: &FemModel, cables: &[Vec<Embedding>]) -> Self {
        let mut starts = vec![0];
        let mut points = Vec::new();
        for cable in cables {
            for point in cable {
                let carriers = point.nodes.iter().copied().zip(point.weights.iter().copied());
                points.push(Carried(carriers.filter(|(_, weight)| *weight != 0.0).collect()));
            }
            starts.push(points.len());
        }
        let mut new = Self { starts, points, rest_lengths: vec![0.0; cables.len()] };
        let mut shape = new.shape();
        new.measure(&model.rest, &mut shape);
        new.rest_lengths = shape.strokes.iter().map(|stroke| -stroke).collect();
        new
    }

    /// Number of cables.
    pub fn len(&self) -> usize {
        self.rest_lengths.len()
    }

    /// True when there is none.
    pub fn is_empty(&self) -> bool {
        self.rest_lengths.is_empty()
    }

    /// Positions of the points of cable `j` when the nodes are at `x` [m].
    pub fn polyline(&self, j: usize, x: &[[f64; 4]]) -> Vec<[f64; 3]> {
        self.points[self.range(j)].iter().map(|point| point.at(x)).collect()
    }

    /// Scratch for [`Self::measure`].
    pub(crate) fn shape(&self) -> CableShape {
        CableShape {
            gradients: vec![[0.0; 3]; self.points.len()],
            positions: vec![[0.0; 3]; self.points.len()],
            strokes: vec![0.0; self.len()],
        }
    }

    fn range(&self, j: usize) -> std::ops::Range<usize> {
        self.starts[j]..self.starts[j + 1]
    }

    /// Strokes and their gradients at positions `x`.
    pub(crate) fn measure(&self, x: &[[f64; 4]], shape: &mut CableShape) {
        for (point, position) in self.points.iter().zip(&mut shape.positions) {
            *position = point.at(x);
        }
        for j in 0..self.len() {
            let range = self.range(j);
            shape.gradients[range.clone()].fill([0.0; 3]);
            let mut length = 0.0;
            for p in range.start..range.end - 1 {
                let (direction, segment) = direction(&shape.positions[p], &shape.positions[p + 1]);
                length += segment;
                for c in 0..3 {
                    shape.gradients[p][c] += direction[c];
                    shape.gradients[p + 1][c] -= direction[c];
                }
            }
            shape.strokes[j] = self.rest_lengths[j] - length;
        }
    }

    /// Adds Jᵀ T to nodal forces (model order).
    pub(crate) fn add_forces(&self, shape: &CableShape, tensions: &[f64], out: &mut [[f64; 4]]) {
        for (j, tension) in tensions.iter().enumerate() {
            if *tension == 0.0 {
                continue;
            }
            for p in self.range(j) {
                for &(node, weight) in &self.points[p].0 {
                    let scale = tension * weight;
                    for c in 0..3 {
                        out[node as usize][c] += scale * shape.gradients[p][c];
                    }
                }
            }
        }
    }

    /// Row j of J times a displacement of the free unknowns: the change of stroke j.
    pub(crate) fn row_times(&self, shape: &CableShape, j: usize, displacement: &[f64]) -> f64 {
        let mut change = 0.0;
        for p in self.range(j) {
            for &(node, weight) in &self.points[p].0 {
                let first = 3 * node as usize;
                // Clamped nodes come after the free unknowns and do not move.
                if let Some(moved) = displacement.get(first..first + 3) {
                    let g = &shape.gradients[p];
                    change += weight * (g[0] * moved[0] + g[1] * moved[1] + g[2] * moved[2]);
                }
            }
        }
        change
    }

    /// Writes row j of J as a dense vector of the free unknowns.
    pub(crate) fn row_into(&self, shape: &CableShape, j: usize, row: &mut [f64]) {
        row.fill(0.0);
        for p in self.range(j) {
            for &(node, weight) in &self.points[p].0 {
                let first = 3 * node as usize;
                if let Some(target) = row.get_mut(first..first + 3) {
                    for c in 0..3 {
                        target[c] += weight * shape.gradients[p][c];
                    }
                }
            }
        }
    }

    /// Node sets that the tensions couple: the carriers of every two neighbouring points.
    pub(crate) fn couplings(&self) -> Vec<Vec<u32>> {
        let mut couplings = Vec::new();
        for j in 0..self.len() {
            let range = self.range(j);
            for p in range.start..range.end - 1 {
                let pair = self.points[p].0.iter().chain(&self.points[p + 1].0);
                couplings.push(pair.map(|(node, _)| *node).collect());
            }
        }
        couplings
    }

    /// Adds the cables' geometric stiffness, T/ℓ (1 - t tᵀ) between the ends of every segment.
    pub(crate) fn add_stiffness(
        &self,
        shape: &CableShape,
        tensions: &[f64],
        pattern: &StiffnessPattern,
        stiffness: &mut Stiffness,
    ) {
        for (j, &tension) in tensions.iter().enumerate() {
            let range = self.range(j);
            for p in range.start..range.end - 1 {
                let (t, length) = direction(&shape.positions[p], &shape.positions[p + 1]);
                let across: [[f64; 3]; 3] = std::array::from_fn(|a| {
                    std::array::from_fn(|b| tension / length * (f64::from(u8::from(a == b)) - t[a] * t[b]))
                });
                let ends = [(&self.points[p], 1.0), (&self.points[p + 1], -1.0)];
                let carriers =
                    ends.iter().flat_map(|(point, sign)| point.0.iter().map(move |(n, w)| (*n, sign * w)));
                let carriers: Vec<(u32, f64)> = carriers.collect();
                for &(row, row_weight) in &carriers {
                    for &(column, column_weight) in carriers.iter().filter(|(column, _)| *column <= row) {
                        let Some(slot) = pattern.slot(row as usize, column as usize) else { continue };
                        for a in 0..3 {
                            for b in 0..3 {
                                stiffness.blocks[slot][a][b] += row_weight * column_weight * across[a][b];
                            }
                        }
                    }
                }
            }
        }
    }
}

impl Carried {
    fn at(&self, x: &[[f64; 4]]) -> [f64; 3] {
        let mut point = [0.0; 3];
        for &(node, weight) in &self.0 {
            for c in 0..3 {
                point[c] += weight * x[node as usize][c];
            }
        }
        point
    }
}

/// Unit vector from `a` to `b`, and their distance.
fn direction(a: &[f64; 3], b: &[f64; 3]) -> ([f64; 3], f64) {
    let d = [b[0] - a[0], b[1] - a[1], b[2] - a[2]];
    let length = (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt();
    (d.map(|c| c / length), length)
}
