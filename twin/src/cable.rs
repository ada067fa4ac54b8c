//! Tendons as cables through points of the body.
//!
//! A cable is a frictionless polyline; its tension T is the same along it. Its *stroke* is how much it
//! has been shortened, s(x) = L(rest) - L(x), so that a tension does the work T ds on the body, the rows
//! J = ∂s/∂x map tensions to nodal forces Jᵀ T, and T ∂²L/∂x² adds to the stiffness. A cable may stretch
//! as well: the length pulled at its end is s + C T.

use hysteron_fem::{Embedding, FemModel, Stiffness, StiffnessPattern};

/// All cables of a robot: primary ones first, then auxiliary ones, then those of friction. Never changes.
#[derive(Debug, Clone)]
pub struct Cables {
    /// First point of each cable, and one past the last point.
    starts: Vec<usize>,
    /// Points in order along each cable.
    points: Vec<CarriedPoint>,
    /// Rest length of each cable [m].
    pub rest_lengths: Vec<f64>,
    /// C, how much each cable stretches per tension: rows of (cable, compliance [m/N]), symmetric; a row is
    /// empty where the cable keeps its length.
    pub compliance: Vec<Vec<(usize, f64)>>,
}

/// Where a cable passes.
#[derive(Debug, Clone, PartialEq)]
pub enum CablePoint {
    /// A point of the body.
    Carried(Embedding),
    /// A point that acts on many nodes.
    Anchored {
        /// The nodes on which it acts.
        carriers: Embedding,
        /// A few of them that stand for all in the stiffness.
        core: Embedding,
    },
    /// A point fixed in space [m].
    Fixed([f64; 3]),
}

impl CablePoint {
    /// The nodes on which it acts; none for a point fixed in space.
    pub(crate) fn carriers(&self) -> Option<&Embedding> {
        match self {
            Self::Carried(carriers) | Self::Anchored { carriers, .. } => Some(carriers),
            Self::Fixed(_) => None,
        }
    }
}

/// A cable point: where it is without the body, and the nodes that carry it, with weights. A fixed point has no
/// carriers, so that its columns of J and of the stiffness are zero; a carried one starts from the origin.
#[derive(Debug, Clone, PartialEq)]
struct CarriedPoint {
    offset: [f64; 3],
    carriers: Vec<(u32, f64)>,
    /// Carriers in the stiffness. Those of an anchor would couple each of hundreds of nodes with every other; its core
    /// moves as it does in every affine motion and nearly so in others, and the iteration makes up for the rest.
    coupled: Vec<(u32, f64)>,
}

/// Unit direction of every segment and length of every cable at some positions; scratch.
#[derive(Debug, Clone)]
pub(crate) struct CableShape {
    /// ∂s/∂P of each cable point.
    pub gradients: Vec<[f64; 3]>,
    /// Position of each cable point [m].
    pub positions: Vec<[f64; 3]>,
    /// Stroke of each cable [m].
    pub strokes: Vec<f64>,
}

impl Cables {
    /// Cables through points, at least two each.
    pub fn new(model: &FemModel, cables: &[Vec<CablePoint>]) -> Self {
        let mut starts = vec![0];
        let mut points = Vec::new();
        for cable in cables {
            points.extend(cable.iter().map(CarriedPoint::new));
            starts.push(points.len());
        }
        let n = cables.len();
        let mut new = Self { starts, points, rest_lengths: vec![0.0; n], compliance: vec![Vec::new(); n] };
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

    /// Length of the longest cable at rest [m]; zero where there is none.
    pub fn longest(&self) -> f64 {
        self.rest_lengths.iter().copied().fold(0.0, f64::max)
    }

    /// Row j of C T: how much cable `j` is stretched [m].
    pub fn stretch(&self, j: usize, tensions: &[f64]) -> f64 {
        self.compliance[j].iter().map(|&(k, compliance)| compliance * tensions[k]).sum()
    }

    /// Diagonal entry j of C [m/N].
    pub(crate) fn own_compliance(&self, j: usize) -> f64 {
        self.compliance[j].iter().find(|(k, _)| *k == j).map_or(0.0, |(_, compliance)| *compliance)
    }

    /// Positions of the points of cable `j` when the nodes are at `x` [m].
    pub fn polyline(&self, j: usize, x: &[[f64; 4]]) -> Vec<[f64; 3]> {
        self.points[self.points_of(j)].iter().map(|point| point.at(x)).collect()
    }

    /// Scratch for [`Self::measure`].
    pub(crate) fn shape(&self) -> CableShape {
        CableShape {
            gradients: vec![[0.0; 3]; self.points.len()],
            positions: vec![[0.0; 3]; self.points.len()],
            strokes: vec![0.0; self.len()],
        }
    }

    /// Numbers of the points of cable `j` among those of all cables.
    pub(crate) fn points_of(&self, j: usize) -> std::ops::Range<usize> {
        self.starts[j]..self.starts[j + 1]
    }

    /// Length by which cable `j` has been pulled at its end, s + C T [m].
    pub(crate) fn pulled(&self, shape: &CableShape, j: usize, tensions: &[f64]) -> f64 {
        shape.strokes[j] + self.stretch(j, tensions)
    }

    /// Carriers of a point of all, with weights; a fixed one has none.
    pub(crate) fn carriers(&self, point: usize) -> &[(u32, f64)] {
        &self.points[point].carriers
    }

    /// Where a point of all is without what carries it [m].
    pub(crate) fn offset(&self, point: usize) -> [f64; 3] {
        self.points[point].offset
    }

    /// True where the segments that begin at points `p` and `q` of all are one and the same.
    pub(crate) fn is_same_segment(&self, p: usize, q: usize) -> bool {
        self.points[p..p + 2] == self.points[q..q + 2]
    }

    /// The same cables on another body: `map` turns where each point is without the body [m], and what carries it, into those
    /// of the other.
    pub(crate) fn carried_by(
        &self,
        mut map: impl FnMut([f64; 3], &[(u32, f64)]) -> ([f64; 3], Vec<(u32, f64)>),
    ) -> Self {
        let mut new = self.clone();
        for point in &mut new.points {
            (point.offset, point.carriers) = map(point.offset, &point.carriers);
            point.coupled.clear();
        }
        new
    }

    /// Strokes and their gradients at positions `x`.
    pub(crate) fn measure(&self, x: &[[f64; 4]], shape: &mut CableShape) {
        for (point, position) in self.points.iter().zip(&mut shape.positions) {
            *position = point.at(x);
        }
        for j in 0..self.len() {
            let range = self.points_of(j);
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

    /// Wrap angle of cable `j` at some of its inner points together [rad].
    pub(crate) fn wrap_angle(&self, shape: &CableShape, j: usize, points: std::ops::Range<usize>) -> f64 {
        let positions = &shape.positions[self.points_of(j)];
        let angle = |k: usize| {
            let (a, _) = direction(&positions[k - 1], &positions[k]);
            let (b, _) = direction(&positions[k], &positions[k + 1]);
            // |a - b| and |a + b| are the sine and cosine of half the angle, twice.
            let sum_of_squares = |sign: f64| (0..3).map(|c| (a[c] + sign * b[c]).powi(2)).sum::<f64>();
            2.0 * sum_of_squares(-1.0).sqrt().atan2(sum_of_squares(1.0).sqrt())
        };
        points.map(angle).sum()
    }

    /// Adds Jᵀ T to nodal forces (model order).
    pub(crate) fn add_forces(&self, shape: &CableShape, tensions: &[f64], out: &mut [[f64; 4]]) {
        for (j, tension) in tensions.iter().enumerate().filter(|(_, tension)| **tension != 0.0) {
            self.add_forces_of(shape, j, *tension, out);
        }
    }

    /// Adds the forces of cable `j` with a tension [N].
    pub(crate) fn add_forces_of(&self, shape: &CableShape, j: usize, tension: f64, out: &mut [[f64; 4]]) {
        for p in self.points_of(j) {
            for &(node, weight) in &self.points[p].carriers {
                let scale = tension * weight;
                for c in 0..3 {
                    out[node as usize][c] += scale * shape.gradients[p][c];
                }
            }
        }
    }

    /// Row j of J times a displacement of the free unknowns: the change of stroke j.
    pub(crate) fn row_times(&self, shape: &CableShape, j: usize, displacement: &[f64]) -> f64 {
        let mut change = 0.0;
        for p in self.points_of(j) {
            for &(node, weight) in &self.points[p].carriers {
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
        for p in self.points_of(j) {
            for &(node, weight) in &self.points[p].carriers {
                let first = 3 * node as usize;
                if let Some(target) = row.get_mut(first..first + 3) {
                    for c in 0..3 {
                        target[c] += weight * shape.gradients[p][c];
                    }
                }
            }
        }
    }

    /// Node sets that the tensions couple: the carriers of every two neighbouring points, fixed ones having none.
    pub(crate) fn couplings(&self) -> Vec<Vec<u32>> {
        let mut couplings = Vec::new();
        for j in 0..self.len() {
            let range = self.points_of(j);
            for p in range.start..range.end - 1 {
                let pair = self.points[p].coupled.iter().chain(&self.points[p + 1].coupled);
                couplings.push(pair.map(|(node, _)| *node).collect());
            }
        }
        couplings
    }

    /// Adds the cables' geometric stiffness, T/ℓ (1 - t tᵀ) between the ends of every segment; for an anchored end that of
    /// its core.
    pub(crate) fn add_stiffness(
        &self,
        shape: &CableShape,
        tensions: &[f64],
        pattern: &StiffnessPattern,
        stiffness: &mut Stiffness,
    ) {
        for (j, &tension) in tensions.iter().enumerate() {
            let range = self.points_of(j);
            for p in range.start..range.end - 1 {
                let (t, length) = direction(&shape.positions[p], &shape.positions[p + 1]);
                let across: [[f64; 3]; 3] = std::array::from_fn(|a| {
                    std::array::from_fn(|b| tension / length * (f64::from(u8::from(a == b)) - t[a] * t[b]))
                });
                let ends = [(&self.points[p], 1.0), (&self.points[p + 1], -1.0)];
                let carriers = ends
                    .iter()
                    .flat_map(|(point, sign)| point.coupled.iter().map(move |(n, w)| (*n, sign * w)));
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

impl CarriedPoint {
    fn new(point: &CablePoint) -> Self {
        match point {
            CablePoint::Fixed(at) => Self { offset: *at, carriers: Vec::new(), coupled: Vec::new() },
            CablePoint::Carried(point) => {
                let carriers = acting(point);
                Self { offset: [0.0; 3], coupled: carriers.clone(), carriers }
            }
            CablePoint::Anchored { carriers, core } => {
                Self { offset: [0.0; 3], carriers: acting(carriers), coupled: acting(core) }
            }
        }
    }

    fn at(&self, x: &[[f64; 4]]) -> [f64; 3] {
        let mut point = self.offset;
        for &(node, weight) in &self.carriers {
            for c in 0..3 {
                point[c] += weight * x[node as usize][c];
            }
        }
        point
    }
}

/// Nodes that move a point, with their weights.
fn acting(point: &Embedding) -> Vec<(u32, f64)> {
    let carriers = point.nodes.iter().copied().zip(point.weights.iter().copied());
    carriers.filter(|(_, weight)| *weight != 0.0).collect()
}

/// Unit vector from `a` to `b`, and their distance.
pub(crate) fn direction(a: &[f64; 3], b: &[f64; 3]) -> ([f64; 3], f64) {
    let d = [b[0] - a[0], b[1] - a[1], b[2] - a[2]];
    let length = (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt();
    (d.map(|c| c / length), length)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use rand::RngExt;

    use super::*;
    use crate::{Twin, scenes};

    /// Step of central differences [m]: their error, step² times the third derivative 1/ℓ², is 1e-8 for
    /// segments ℓ of 4 mm at 0.3 µm; round-off of lengths of 40 mm adds 1e-17 / step = 1e-10.
    const STEP: f64 = 3e-7;
    const GRADIENT_ERROR: f64 = 1e-6;

    /// A twin, its nodes moved at random by up to 0.3 mm, and a direction of free nodes with entries
    /// within ±1.
    fn moved_twin() -> (Twin, Vec<[f64; 4]>, Vec<f64>) {
        let (scene, mesh) = scenes::robot();
        let twin = Twin::new(&scene, &mesh).expect("a good scene");
        let mut rng = hysteron_base::rng(1, "cable");
        let mut x = twin.body.rest.clone();
        for node in &mut x[..twin.body.n_free] {
            for c in 0..3 {
                node[c] += rng.random_range(-3e-4..3e-4);
            }
        }
        let direction = (0..twin.body.n_unknowns()).map(|_| rng.random_range(-1.0..1.0)).collect();
        (twin, x, direction)
    }

    fn displaced(x: &[[f64; 4]], factor: f64, direction: &[f64]) -> Vec<[f64; 4]> {
        let mut x = x.to_vec();
        crate::equilibrium_residual::move_nodes(&mut x, factor, direction);
        x
    }

    fn measured(twin: &Twin, x: &[[f64; 4]]) -> CableShape {
        let mut shape = twin.cables.shape();
        twin.cables.measure(x, &mut shape);
        shape
    }

    fn dot(a: &[f64], b: &[f64]) -> f64 {
        a.iter().zip(b).map(|(a, b)| a * b).sum()
    }

    #[test]
    fn row_is_derivative_of_stroke() {
        let (twin, x, direction) = moved_twin();
        let shape = measured(&twin, &x);
        let ahead = measured(&twin, &displaced(&x, STEP, &direction));
        let behind = measured(&twin, &displaced(&x, -STEP, &direction));
        for j in 0..twin.cables.len() {
            let analytic = twin.cables.row_times(&shape, j, &direction);
            let difference = (ahead.strokes[j] - behind.strokes[j]) / (2.0 * STEP);
            let error = (analytic - difference).abs();
            assert!(error < GRADIENT_ERROR * analytic.abs().max(1.0), "{analytic} and {difference}");
            assert!(error > 0.0 && analytic.abs() > 1e-3, "a difference that tests nothing");
        }
    }

    #[test]
    fn dense_row_is_sparse_row() {
        let (twin, x, direction) = moved_twin();
        let shape = measured(&twin, &x);
        let mut row = vec![f64::NAN; direction.len()];
        for j in 0..twin.cables.len() {
            twin.cables.row_into(&shape, j, &mut row);
            let error = dot(&row, &direction) - twin.cables.row_times(&shape, j, &direction);
            // Round-off of sums of some hundred terms of order one.
            assert!(error.abs() < 1e-13, "{error}");
        }
    }

    #[test]
    fn tension_does_work_on_nodes_as_stroke_grows() {
        let (twin, x, direction) = moved_twin();
        let shape = measured(&twin, &x);
        let tensions = [3.0, 0.0, 1.5, 7.0];
        let mut forces = vec![[0.0; 4]; x.len()];
        twin.cables.add_forces(&shape, &tensions, &mut forces);
        let work_on_nodes: f64 = forces
            .iter()
            .zip(direction.as_chunks::<3>().0)
            .map(|(force, moved)| dot(&force[..3], moved))
            .sum();
        let work_of_cables: f64 =
            (0..4).map(|j| tensions[j] * twin.cables.row_times(&shape, j, &direction)).sum();
        assert!((work_on_nodes - work_of_cables).abs() < 1e-12 * work_on_nodes.abs().max(1.0));
        assert!(work_on_nodes.abs() > 0.1);
    }

    #[test]
    fn geometric_stiffness_is_derivative_of_forces() {
        let (twin, x, direction) = moved_twin();
        let tensions = [3.0, 0.5, 1.5, 7.0];
        let pattern = Arc::new(twin.body.stiffness_pattern(&twin.cables.couplings()));
        let mut stiffness = Stiffness::zeros(pattern.clone());
        twin.cables.add_stiffness(&measured(&twin, &x), &tensions, &pattern, &mut stiffness);
        let mut analytic = vec![0.0; direction.len()];
        stiffness.multiply_into(&direction, &mut analytic);
        let forces = |factor: f64| {
            let x = displaced(&x, factor, &direction);
            let mut forces = vec![[0.0; 4]; x.len()];
            twin.cables.add_forces(&measured(&twin, &x), &tensions, &mut forces);
            forces
        };
        let (ahead, behind) = (forces(STEP), forces(-STEP));
        // Cable forces oppose the stiffness: the residual is internal minus applied.
        let difference: Vec<f64> = (0..direction.len())
            .map(|i| (behind[i / 3][i % 3] - ahead[i / 3][i % 3]) / (2.0 * STEP))
            .collect();
        let size = analytic.iter().fold(0.0f64, |max, k| max.max(k.abs()));
        let error = analytic.iter().zip(&difference).fold(0.0f64, |max, (a, d)| max.max((a - d).abs()));
        assert!(error < GRADIENT_ERROR * size, "{error} of {size} N/m");
        assert!(error > 0.0 && size > 100.0, "a difference that tests nothing");
    }

    #[test]
    fn rest_length_is_sum_of_segments() {
        // A quarter circle of 64 chords of 2 r sin(π/256) each, embedded in the tube's wall.
        let (scene, mesh) = scenes::robot();
        let twin = Twin::new(&scene, &mesh).expect("a good scene");
        let radius = 0.005;
        let point = |k: usize| {
            let angle = std::f64::consts::FRAC_PI_2 * k as f64 / 64.0;
            [radius * angle.cos(), radius * angle.sin(), 0.02]
        };
        let carried: Vec<CablePoint> =
            (0..=64).map(|k| CablePoint::Carried(Embedding::new(&twin.body, point(k)))).collect();
        let cables = Cables::new(&twin.body, &[carried]);
        let expected = 64.0 * 2.0 * radius * (std::f64::consts::PI / 256.0).sin();
        assert!((cables.rest_lengths[0] - expected).abs() < 1e-15);
        let polyline = cables.polyline(0, &twin.body.rest);
        for (k, found) in polyline.iter().enumerate() {
            for c in 0..3 {
                assert!((found[c] - point(k)[c]).abs() < 1e-16);
            }
        }
    }

    #[test]
    fn rigid_motion_keeps_length() {
        let (scene, mesh) = scenes::robot();
        let twin = Twin::new(&scene, &mesh).expect("a good scene");
        let turn = nalgebra::Rotation3::from_euler_angles(0.7, -1.9, 2.5);
        let x: Vec<[f64; 4]> = twin
            .body
            .rest
            .iter()
            .map(|[x, y, z, _]| {
                let p = turn * nalgebra::Vector3::new(*x, *y, *z) + nalgebra::Vector3::new(0.3, -0.1, 0.2);
                [p.x, p.y, p.z, 0.0]
            })
            .collect();
        for stroke in measured(&twin, &x).strokes {
            // Round-off of positions of 0.3 m.
            assert!(stroke.abs() < 1e-15, "{stroke}");
        }
    }

    #[test]
    fn clamped_carriers_do_not_move() {
        // The first point of every tendon sits on the clamp: only the others may appear in the row.
        let (twin, x, _) = moved_twin();
        let shape = measured(&twin, &x);
        let mut forces = vec![[0.0; 4]; x.len()];
        twin.cables.add_forces(&shape, &[1.0, 0.0, 0.0, 0.0], &mut forces);
        let mut row = vec![0.0; twin.body.n_unknowns()];
        twin.cables.row_into(&shape, 0, &mut row);
        let on_clamp: f64 = forces[twin.body.n_free..].iter().map(|force| force[2]).sum();
        let on_free: f64 = row.iter().skip(2).step_by(3).sum();
        assert!(on_clamp > 0.5, "the pulled end draws the clamp towards the tip: {on_clamp}");
        assert!((on_free + on_clamp).abs() < 1e-14, "{on_free}");
    }
}
