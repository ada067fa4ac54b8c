//! The law of a section, condensed from its finite elements.
//!
//! The nodes of the two interfaces follow their frames and warpings exactly; the inner ones follow to first order, which gives
//! the energy exactly to third order. The cubic term is found from forces at a few amplitudes of either sign.

use std::sync::Arc;

use hysteron_base::MaterialLaw;
use hysteron_fem::{Cells, FactorKind, FemModel, Mesh, Stiffness, StiffnessFactor, Tangent};
use nalgebra::{Matrix3, Vector3};

use super::cubic::Cubic;
use super::cut::Cut;
use super::rotation::{HalfAngle, exp};
use super::section::SectionLaw;
use super::warping::{InterfaceShape, rest};
use super::{PADDED, POSE, STRAIN, Strain, WARPINGS};
use crate::Result;

/// Amplitudes of the differences: displacements over the section's length, and half of it as angle [rad]. Their error is of
/// second order, 1e-6; round-off is 1e-16 over it.
const AMPLITUDE: f64 = 1e-3;

/// A condensed section.
pub(crate) struct Condensed {
    pub law: SectionLaw,
    /// Its nodes, model order of the body.
    pub nodes: Vec<u32>,
    /// Ψ of each node by rows: displacement in the section's frame per strain.
    pub shapes: Vec<[Strain; 3]>,
    /// Rest position of its own frame, and of its end interface's [m].
    pub center: Vector3<f64>,
    pub end: Vector3<f64>,
    /// K_ii, factorised, of the inner nodes, which come first; `None` without any.
    factor: Option<StiffnessFactor>,
    n_inner: usize,
    /// Largest difference between entries of A that should be equal, over its largest entry, in units of the amplitudes [-].
    pub asymmetry: f64,
}

/// Where a node of a section lies.
#[derive(Debug, Clone, Copy)]
enum InterfaceSide {
    /// On the first interface: number there.
    Near(usize),
    /// On the second.
    Far(usize),
    Inner,
}

/// The elements of one section.
struct SectionMesh<'a> {
    model: FemModel,
    /// The same with the law that is linear: its forces at rest and a displacement are K u.
    linear: FemModel,
    /// Node of the body of each node, model order of the section.
    nodes: Vec<u32>,
    sides: Vec<InterfaceSide>,
    near: &'a InterfaceShape,
    far: &'a InterfaceShape,
}

/// Condenses section `e` of a body, between two interfaces.
///
/// # Errors
/// Inner nodes that nothing holds.
pub(crate) fn condense(
    body: &FemModel,
    cut: &Cut,
    e: usize,
    (near, far): (&InterfaceShape, &InterfaceShape),
) -> Result<Condensed> {
    let section = SectionMesh::new(body, cut, e, near, far)?;
    let mut factor = section.inner_factor()?;
    let shapes = section.shapes(factor.as_mut());
    let mut stiffness = section.stiffness(&shapes);
    let (cubic, asymmetry) = section.cubic(&shapes);
    // An amplitude without a warping is held at zero.
    let strongest = (0..STRAIN).map(|k| stiffness[k][k]).fold(0.0, f64::max);
    for k in (0..STRAIN).filter(|&k| !section.is_moved_by(k)) {
        stiffness[k] = [0.0; PADDED];
        stiffness.iter_mut().for_each(|row| row[k] = 0.0);
        stiffness[k][k] = strongest;
    }
    Ok(Condensed {
        law: SectionLaw {
            rest: far.center - near.center,
            stiffness,
            cubic,
            scale: body.material.youngs_modulus * section.model.nodal_volumes.iter().sum::<f64>(),
        },
        n_inner: section.n_inner(),
        nodes: section.nodes,
        shapes,
        center: 0.5 * (near.center + far.center),
        end: far.center,
        factor,
        asymmetry,
    })
}

impl Condensed {
    /// N K_ii⁻¹ Nᵀ of sums of inner nodes, each given by nodes of the body and weights: how far they give way to forces on
    /// them between interfaces that are held [m/N], rows and columns by sum, then axis.
    pub fn local_compliance(&mut self, sums: &[&[(u32, f64)]]) -> Vec<f64> {
        let Some(factor) = &mut self.factor else { return Vec::new() };
        let mut pulls = Vec::new();
        for (sum, c) in sums.iter().flat_map(|sum| (0..3).map(move |c| (sum, c))) {
            let mut pull = vec![0.0; 3 * self.n_inner];
            for &(node, weight) in sum.iter() {
                if let Some(i) = self.nodes[..self.n_inner].iter().position(|&own| own == node) {
                    pull[3 * i + c] += weight;
                }
            }
            pulls.push(pull);
        }
        let mut moved = pulls.clone();
        factor.solve_many(&mut moved);
        let product = |a: &Vec<f64>, b: &Vec<f64>| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        pulls.iter().flat_map(|pull| moved.iter().map(move |moved| product(pull, moved))).collect()
    }
}

impl<'a> SectionMesh<'a> {
    fn new(
        body: &FemModel,
        cut: &Cut,
        e: usize,
        near: &'a InterfaceShape,
        far: &'a InterfaceShape,
    ) -> Result<Self> {
        let own = |cell: &usize| cut.sections[*cell] == Some(e);
        let cells: Vec<usize> = (0..body.cells.len()).filter(own).collect();
        let mut nodes: Vec<u32> = cells.iter().flat_map(|&cell| body.cells.nodes(cell).to_vec()).collect();
        nodes.sort_unstable();
        nodes.dedup();
        let number = |node: u32| nodes.binary_search(&node).map_or(0, |at| at as u32);
        let side = |node: u32| match (near.nodes.binary_search(&node), far.nodes.binary_search(&node)) {
            (Ok(i), _) => InterfaceSide::Near(i),
            (_, Ok(i)) => InterfaceSide::Far(i),
            _ => InterfaceSide::Inner,
        };
        let mesh = Mesh {
            nodes: nodes.iter().map(|&node| rest(body, node).into()).collect(),
            cells: match &body.cells {
                Cells::Tet4(all) => Cells::Tet4(cells.iter().map(|&cell| all[cell].map(number)).collect()),
                Cells::Tet10(all) => Cells::Tet10(cells.iter().map(|&cell| all[cell].map(number)).collect()),
            },
            groups: Default::default(),
        };
        let on = |far_too: &dyn Fn(InterfaceSide) -> bool| -> Vec<u32> {
            let clamped = nodes.iter().zip(0..).filter(|(node, _)| far_too(side(**node)));
            clamped.map(|(_, i)| i).collect()
        };
        let mut clamped = on(&|side| !matches!(side, InterfaceSide::Inner));
        if clamped.len() == nodes.len() {
            // Nothing to condense: linear elements in one layer.
            clamped = on(&|side| matches!(side, InterfaceSide::Near(_)));
        }
        let ratios = cells.iter().map(|&cell| body.modulus_ratios[cell]).collect();
        let model = FemModel::new(&mesh, body.material.clone(), &clamped)?.with_modulus_ratios(ratios);
        let nodes: Vec<u32> = model.file_node.iter().map(|&file| nodes[file as usize]).collect();
        let sides = nodes.iter().map(|&node| side(node)).collect();
        let mut linear = model.clone();
        linear.material.law = MaterialLaw::SmallStrain;
        Ok(Self { model, linear, nodes, sides, near, far })
    }

    /// Rest position of a node [m].
    fn rest(&self, i: usize) -> Vector3<f64> {
        rest(&self.model, i as u32)
    }

    /// True unless strain `k` is the amplitude of a warping that is zero.
    fn is_moved_by(&self, k: usize) -> bool {
        let (side, k) = match k {
            0..POSE => return true,
            _ if k < POSE + WARPINGS => (self.near, k - POSE),
            _ => (self.far, k - POSE - WARPINGS),
        };
        side.warpings.iter().any(|of_node| of_node[k] != Vector3::zeros())
    }

    /// First-order displacement of every node per strain.
    fn shapes(&self, factor: Option<&mut StiffnessFactor>) -> Vec<[Strain; 3]> {
        let mut shapes = vec![[[0.0; PADDED]; 3]; self.nodes.len()];
        for (i, shape) in shapes.iter_mut().enumerate() {
            let (sign, arm, first, warpings) = match self.sides[i] {
                InterfaceSide::Near(k) => {
                    (-0.5, self.rest(i) - self.near.center, POSE, &self.near.warpings[k])
                }
                InterfaceSide::Far(k) => {
                    (0.5, self.rest(i) - self.far.center, POSE + WARPINGS, &self.far.warpings[k])
                }
                InterfaceSide::Inner => continue,
            };
            let turned = -sign * arm.cross_matrix();
            for c in 0..3 {
                shape[c][c] = sign;
                for k in 0..3 {
                    shape[c][3 + k] = turned[(c, k)];
                }
                for k in 0..WARPINGS {
                    shape[c][first + k] = warpings[k][c];
                }
            }
        }
        if let Some(factor) = factor {
            self.follow_interfaces(factor, &mut shapes);
        }
        shapes
    }

    /// Number of inner nodes, which come first.
    fn n_inner(&self) -> usize {
        self.sides.iter().take_while(|side| matches!(side, InterfaceSide::Inner)).count()
    }

    /// K_ii, factorised; `None` without inner nodes.
    fn inner_factor(&self) -> Result<Option<StiffnessFactor>> {
        if self.n_inner() == 0 {
            return Ok(None);
        }
        let pattern = Arc::new(self.model.stiffness_pattern(&[]));
        let mut factor = StiffnessFactor::new(&pattern, FactorKind::Supernodal, self.model.isa);
        let mut stiffness = Stiffness::zeros(pattern);
        self.model.stiffness_into(&self.model.rest, Tangent::Exact, &mut stiffness);
        factor.factorize(&stiffness)?;
        Ok(Some(factor))
    }

    /// Sets the inner nodes' displacements to those that balance: -K_ii⁻¹ K_ib u_b.
    fn follow_interfaces(&self, factor: &mut StiffnessFactor, shapes: &mut [[Strain; 3]]) {
        let inner = self.n_inner();
        let mut columns: Vec<Vec<f64>> = (0..STRAIN)
            .map(|k| {
                self.linear_force(shapes, k)[..inner].iter().flat_map(|force| force[..3].to_vec()).collect()
            })
            .collect();
        factor.solve_many(&mut columns);
        for (k, column) in columns.iter().enumerate() {
            for (shape, moved) in shapes.iter_mut().zip(column.as_chunks::<3>().0) {
                for c in 0..3 {
                    shape[c][k] = -moved[c];
                }
            }
        }
    }

    /// Forces on all nodes per strain `k` at rest, K Ψ_k [N].
    fn linear_force(&self, shapes: &[[Strain; 3]], k: usize) -> Vec<[f64; 4]> {
        let moved = |(rest, shape): (&[f64; 4], &[Strain; 3])| {
            [rest[0] + shape[0][k], rest[1] + shape[1][k], rest[2] + shape[2][k], 0.0]
        };
        let x: Vec<[f64; 4]> = self.linear.rest.iter().zip(shapes).map(moved).collect();
        let mut forces = vec![[0.0; 4]; x.len()];
        self.linear.internal_force_into(&x, &mut forces);
        forces
    }

    /// K_e = Ψᵀ K Ψ.
    fn stiffness(&self, shapes: &[[Strain; 3]]) -> [Strain; STRAIN] {
        let mut stiffness = [[0.0; PADDED]; STRAIN];
        for k in 0..STRAIN {
            let mut row = [0.0; PADDED];
            for (force, shape) in self.linear_force(shapes, k).iter().zip(shapes) {
                add_work(force, shape, &mut row);
            }
            stiffness[k] = row;
        }
        let half = stiffness;
        for k in 0..STRAIN {
            for l in 0..STRAIN {
                stiffness[k][l] = 0.5 * (half[k][l] + half[l][k]);
            }
        }
        stiffness
    }

    /// A_e, and the asymmetry of the differences that it is the mean of.
    fn cubic(&self, shapes: &[[Strain; 3]]) -> (Cubic, f64) {
        let scales: Strain = std::array::from_fn(|k| {
            let length = (self.far.center - self.near.center).norm();
            if (3..POSE).contains(&k) { 0.5 * AMPLITUDE } else { AMPLITUDE * length }
        });
        // Even part of the stress: A[ε, ε], times the scales.
        let even = |changes: &[usize]| {
            let mut strain = [0.0; PADDED];
            for &k in changes {
                strain[k] += scales[k];
            }
            let (ahead, behind) = (self.stress(shapes, &strain), self.stress(shapes, &strain.map(|e| -e)));
            std::array::from_fn::<f64, STRAIN, _>(|k| scales[k] * (ahead[k] + behind[k]))
        };
        let single: Vec<[f64; STRAIN]> = (0..STRAIN).map(|i| even(&[i])).collect();
        let mut pairs = vec![[0.0; STRAIN]; STRAIN * STRAIN];
        for i in 0..STRAIN {
            pairs[i * STRAIN + i] = single[i];
            for j in 0..i {
                let both = even(&[i, j]);
                let product = std::array::from_fn(|k| 0.5 * (both[k] - single[i][k] - single[j][k]));
                pairs[i * STRAIN + j] = product;
                pairs[j * STRAIN + i] = product;
            }
        }
        let (mut largest, mut apart) = (f64::MIN_POSITIVE, 0.0f64);
        for i in 0..STRAIN {
            for j in 0..=i {
                for k in 0..STRAIN {
                    largest = largest.max(pairs[i * STRAIN + j][k].abs());
                    apart = apart.max((pairs[i * STRAIN + j][k] - pairs[i * STRAIN + k][j]).abs());
                }
            }
        }
        let of = |i: usize, j: usize, k: usize| {
            let sum = pairs[i * STRAIN + j][k] + pairs[i * STRAIN + k][j] + pairs[j * STRAIN + k][i];
            sum / (3.0 * scales[i] * scales[j] * scales[k])
        };
        (Cubic::new(of), apart / largest)
    }

    /// σ = ∂W/∂ε with the interfaces moved exactly.
    fn stress(&self, shapes: &[[Strain; 3]], strain: &Strain) -> Strain {
        let (x, turn) = self.positions(shapes, strain);
        let mut forces = vec![[0.0; 4]; x.len()];
        self.model.internal_force_into(&x, &mut forces);
        let mut stress = [0.0; PADDED];
        let chord = Vector3::new(strain[0], strain[1], strain[2]) + self.far.center - self.near.center;
        let middle = 0.5 * (self.near.center + self.far.center);
        let half = 0.5 * Vector3::new(strain[3], strain[4], strain[5]);
        let coefficients = HalfAngle::new(half.norm_squared());
        let cross = half.cross_matrix();
        let spin = Matrix3::identity() + coefficients.kappa * cross + coefficients.g * cross * cross;
        let (mut normal, mut bending) = (Vector3::zeros(), Vector3::zeros());
        for (i, force) in forces.iter().enumerate() {
            let at = Vector3::new(x[i][0], x[i][1], x[i][2]);
            let force = Vector3::new(force[0], force[1], force[2]);
            match self.sides[i] {
                InterfaceSide::Inner => add_work(&forces[i], &shapes[i], &mut stress),
                InterfaceSide::Near(k) => {
                    normal -= 0.5 * force;
                    bending -= 0.5 * spin * (at - (middle - 0.5 * chord)).cross(&force);
                    let local = turn * force;
                    for (w, warping) in self.near.warpings[k].iter().enumerate() {
                        stress[POSE + w] += warping.dot(&local);
                    }
                }
                InterfaceSide::Far(k) => {
                    normal += 0.5 * force;
                    bending += 0.5 * spin.transpose() * (at - (middle + 0.5 * chord)).cross(&force);
                    let local = turn.transpose() * force;
                    for (w, warping) in self.far.warpings[k].iter().enumerate() {
                        stress[POSE + WARPINGS + w] += warping.dot(&local);
                    }
                }
            }
        }
        for c in 0..3 {
            stress[c] += normal[c];
            stress[3 + c] += bending[c];
        }
        stress
    }

    /// Positions of the nodes in the section's frame [m], and exp(ψ/2).
    fn positions(&self, shapes: &[[Strain; 3]], strain: &Strain) -> (Vec<[f64; 4]>, Matrix3<f64>) {
        let chord = Vector3::new(strain[0], strain[1], strain[2]) + self.far.center - self.near.center;
        let middle = 0.5 * (self.near.center + self.far.center);
        let turn = exp(&(0.5 * Vector3::new(strain[3], strain[4], strain[5])));
        let warped = |arm: Vector3<f64>, warpings: &[Vector3<f64>; WARPINGS], first: usize| {
            warpings
                .iter()
                .zip(&strain[first..])
                .fold(arm, |sum, (warping, amplitude)| sum + *amplitude * warping)
        };
        let position = |i: usize| {
            let at = match self.sides[i] {
                InterfaceSide::Near(k) => {
                    let arm = warped(self.rest(i) - self.near.center, &self.near.warpings[k], POSE);
                    middle - 0.5 * chord + turn.transpose() * arm
                }
                InterfaceSide::Far(k) => {
                    let arm = warped(self.rest(i) - self.far.center, &self.far.warpings[k], POSE + WARPINGS);
                    middle + 0.5 * chord + turn * arm
                }
                InterfaceSide::Inner => {
                    let moved = shapes[i].map(|row| row.iter().zip(strain).map(|(a, b)| a * b).sum::<f64>());
                    self.rest(i) + Vector3::from(moved)
                }
            };
            [at[0], at[1], at[2], 0.0]
        };
        ((0..self.nodes.len()).map(position).collect(), turn)
    }
}

/// Adds the work of a node's force per strain.
fn add_work(force: &[f64; 4], shape: &[Strain; 3], stress: &mut Strain) {
    for c in 0..3 {
        for (stress, shape) in stress.iter_mut().zip(&shape[c]) {
            *stress += force[c] * shape;
        }
    }
}

#[cfg(test)]
mod tests {
    use hysteron_fem::Order;
    use rand::RngExt;

    use super::*;
    use crate::chain::warping::interfaces;
    use crate::{Twin, scenes};

    /// The third section of a robot, three layers of elements, and its interfaces.
    fn section(law: MaterialLaw, order: Order, check: impl Fn(&SectionMesh, &[[Strain; 3]], &Condensed)) {
        let (scene, mesh) = scenes::robot_with(law, order, 24);
        let twin = Twin::new(&scene, &mesh).expect("a good scene");
        let cut = Cut::new(&twin.body, &[]).expect("a cut");
        let interfaces = interfaces(&twin, &cut).expect("responses");
        let (near, far) = (&interfaces[2], &interfaces[3]);
        let section = SectionMesh::new(&twin.body, &cut, 2, near, far).expect("a section");
        let shapes = section.shapes(section.inner_factor().expect("a factor").as_mut());
        check(&section, &shapes, &condense(&twin.body, &cut, 2, (near, far)).expect("a law"));
    }

    /// A strain of `size` of the section's length.
    fn random_strain(section: &SectionMesh, size: f64) -> Strain {
        let mut rng = hysteron_base::rng(1, "section");
        let length = (section.far.center - section.near.center).norm();
        let mut strain = [0.0; PADDED];
        for (k, strain) in strain[..STRAIN].iter_mut().enumerate() {
            *strain = size * rng.random_range(-1.0..1.0) * if (3..POSE).contains(&k) { 1.0 } else { length };
        }
        strain
    }

    #[test]
    fn stress_is_derivative_of_the_elements_energy() {
        section(MaterialLaw::Corotational, Order::Quadratic, |section, shapes, _| {
            let strain = random_strain(section, 0.05);
            let stress = section.stress(shapes, &strain);
            let size = stress.iter().fold(0.0f64, |max, s| max.max(s.abs()));
            for k in 0..STRAIN {
                // Truncation 1e-8 of the stress; round-off 1e-16 J over the step.
                let step = if (3..POSE).contains(&k) { 1e-5 } else { 1e-8 };
                let energy = |sign: f64| {
                    let mut moved = strain;
                    moved[k] += sign * step;
                    section.model.energy(&section.positions(shapes, &moved).0)
                };
                let difference = (energy(1.0) - energy(-1.0)) / (2.0 * step);
                let scale = if (3..POSE).contains(&k) { 1e-3 } else { 1.0 };
                assert!(
                    (stress[k] - difference).abs() < 1e-6 * scale * size,
                    "{k}: {} {difference}",
                    stress[k]
                );
            }
        });
    }

    #[test]
    fn law_leaves_a_remainder_of_third_order_in_the_stress() {
        for law in [MaterialLaw::Corotational, MaterialLaw::NeoHookean] {
            section(law, Order::Linear, |section, shapes, condensed| {
                assert!(condensed.asymmetry < 1e-4, "{}", condensed.asymmetry);
                let remainder = |size: f64| {
                    let strain = random_strain(section, size);
                    let exact = section.stress(shapes, &strain);
                    let stress = condensed.law.stress(section.model.isa, &strain).stress;
                    exact.iter().zip(&stress).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
                };
                // Halved strains leave an eighth; the fourth order is as many per cent of the third as the strain.
                let (whole, half) = (remainder(2e-3), remainder(1e-3));
                assert!((whole / half - 8.0).abs() < 0.4, "{law:?}: {whole} and {half}");
            });
        }
    }
}
