//! The loops over all elements: energy, nodal forces, stiffness blocks.

use hysteron_base::{Material, MaterialLaw};

use super::batch::{ElementBatch, PairMap, PointData};
use super::law::{
    Corotational, CorotationalEdges, Lame, NeoHookean, PointLaw, QuadraturePoint, SmallStrain, Tangent,
    lame_parameters,
};
use super::tensor::{Mat3, Vec3, apply, cofactor, cross, dot, scale, scale_rows, sub};
use crate::simd::{Isa, LANES, Lanes, Packs, PaddedPoints, Simd, WithSimd, collect, element};

/// A point or force with a fourth number of padding, so that one register holds it.
pub(crate) type Padded = [f64; 4];
/// Padded rows of a 3×3 block.
pub(crate) type PaddedBlock = [Padded; 3];

/// Calls a kernel with the law's type.
macro_rules! with_law {
    ($law:expr, $kernel:expr) => {
        match $law {
            MaterialLaw::SmallStrain => $kernel(SmallStrain),
            MaterialLaw::Corotational => $kernel(Corotational),
            MaterialLaw::CorotationalEdges => $kernel(CorotationalEdges),
            MaterialLaw::NeoHookean => $kernel(NeoHookean),
        }
    };
}

/// Elastic energy \[J\] at positions `x` (model order) \[m\].
pub(crate) fn energy<const N: usize, const Q: usize>(
    isa: Isa,
    elements: &ElementBatch<N, Q>,
    material: &Material,
    x: &[Padded],
) -> f64 {
    with_law!(material.law, |law| isa.run(EnergyKernel { elements, material, law, x }))
}

/// Adds the internal nodal forces ∂ψ/∂x \[N\] at positions `x` to `out` (model order). True if no element is inverted
/// there: det F > 0 in every quadrature point, or not a number.
pub(crate) fn force_into<const N: usize, const Q: usize>(
    isa: Isa,
    elements: &ElementBatch<N, Q>,
    material: &Material,
    x: &[Padded],
    out: &mut [Padded],
) -> bool {
    with_law!(material.law, |law| isa.run(Force { elements, material, law, x, out }))
}

/// Adds the 3×3 stiffness blocks \[N/m\] at positions `x` to `blocks`, each at its place in `map`.
pub(crate) fn stiffness_into<const N: usize, const Q: usize>(
    isa: Isa,
    elements: &ElementBatch<N, Q>,
    material: &Material,
    kind: Tangent,
    x: &[Padded],
    map: &PairMap,
    blocks: &mut [PaddedBlock],
) {
    with_law!(material.law, |law| isa.run(StiffnessKernel { elements, material, law, kind, x, map, blocks }))
}

/// Positions of the nodes of every batch, collected one batch ahead of its use.
struct Collected<'a, const N: usize> {
    nodes: &'a [[[u32; LANES]; N]],
    x: &'a [Padded],
    rows: [[PaddedPoints; N]; 2],
}

impl<'a, const N: usize> Collected<'a, N> {
    #[inline(always)]
    fn new<S: Simd>(nodes: &'a [[[u32; LANES]; N]], x: &'a [Padded]) -> Self {
        let mut collected = Self { nodes, x, rows: [[PaddedPoints::ZERO; N]; 2] };
        collected.collect::<S>(0);
        collected
    }

    #[inline(always)]
    fn collect<S: Simd>(&mut self, batch: usize) {
        if let Some(nodes) = self.nodes.get(batch) {
            for a in 0..N {
                collect::<S>(self.x, &nodes[a], &mut self.rows[batch % 2][a]);
            }
        }
    }

    /// Those of `batch`, which follows on the last one asked for.
    #[inline(always)]
    fn of<S: Simd>(&mut self, batch: usize) -> &[PaddedPoints; N] {
        self.collect::<S>(batch + 1);
        &self.rows[batch % 2]
    }
}

/// Positions of the nodes of a pass relative to node 0 (entry 0 stays unused).
#[inline(always)]
fn edges<S: Simd, const N: usize>(packs: Packs<S>, rows: &[PaddedPoints; N]) -> [Vec3<S>; N] {
    let origin = packs.gather(&rows[0]);
    let mut edges = [origin; N];
    for a in 1..N {
        edges[a] = sub(packs.gather(&rows[a]), origin);
    }
    edges
}

/// Rest gradients of nodes 1.. (entry 0 stays unused).
#[inline(always)]
fn gradients<S: Simd, const N: usize>(packs: Packs<S>, point: &PointData<N>) -> [Vec3<S>; N] {
    let mut gradients = [[packs.splat(0.0); 3]; N];
    for a in 1..N {
        for c in 0..3 {
            gradients[a][c] = packs.load(&point.gradients[a][c]);
        }
    }
    gradients
}

/// A quadrature point of a pass in its deformed state.
struct Deformed<S: Simd, const N: usize> {
    /// Rest gradients of nodes 1.. (entry 0 stays unused).
    gradients: [Vec3<S>; N],
    f: Mat3<S>,
    first_edges: Mat3<S>,
    first_gradients: Mat3<S>,
}

impl<S: Simd, const N: usize> Deformed<S, N> {
    #[inline(always)]
    fn new(packs: Packs<S>, edges: &[Vec3<S>; N], point: &PointData<N>) -> Self {
        let gradients = gradients(packs, point);
        Self {
            f: deformation_gradient(edges, &gradients),
            first_edges: [edges[1], edges[2], edges[3]],
            first_gradients: [gradients[1], gradients[2], gradients[3]],
            gradients,
        }
    }

    /// Arguments of a law at this point.
    #[inline(always)]
    fn at(&self) -> QuadraturePoint<'_, S> {
        QuadraturePoint { f: &self.f, edges: &self.first_edges, gradients: &self.first_gradients }
    }
}

/// F = Σ (x_a - x_0) ⊗ ∇N_a.
#[inline(always)]
fn deformation_gradient<S: Simd, const N: usize>(edges: &[Vec3<S>; N], g: &[Vec3<S>; N]) -> Mat3<S> {
    let mut f = [scale(edges[1][0], g[1]), scale(edges[1][1], g[1]), scale(edges[1][2], g[1])];
    for a in 2..N {
        for i in 0..3 {
            for j in 0..3 {
                f[i][j] = edges[a][i].mul_add(g[a][j], f[i][j]);
            }
        }
    }
    f
}

#[inline(always)]
fn lame<S: Simd>(packs: Packs<S>, material: &Material) -> Lame<S> {
    let (lambda, mu) = lame_parameters(material);
    Lame { lambda: packs.splat(lambda), mu: packs.splat(mu) }
}

struct EnergyKernel<'a, L, const N: usize, const Q: usize> {
    elements: &'a ElementBatch<N, Q>,
    material: &'a Material,
    law: L,
    x: &'a [Padded],
}

impl<L: PointLaw, const N: usize, const Q: usize> WithSimd for EnergyKernel<'_, L, N, Q> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> f64 {
        let mut total = 0.0;
        let mut collected = Collected::new::<S>(&self.elements.nodes, self.x);
        for (batch, points) in self.elements.points.iter().enumerate() {
            let rows = collected.of::<S>(batch);
            for pass in 0..Packs::<S>::PASSES {
                let packs = Packs::new(simd, pass);
                let edges = edges(packs, rows);
                for point in points {
                    let deformed = Deformed::new(packs, &edges, point);
                    let density = self.law.energy(lame(packs, self.material), &deformed.at());
                    let energies = (packs.load(&point.weight) * density).to_array();
                    total += energies[..S::F64_LANES].iter().sum::<f64>();
                }
            }
        }
        total
    }
}

struct Force<'a, L, const N: usize, const Q: usize> {
    elements: &'a ElementBatch<N, Q>,
    material: &'a Material,
    law: L,
    x: &'a [Padded],
    out: &'a mut [Padded],
}

impl<L: PointLaw, const N: usize, const Q: usize> WithSimd for Force<'_, L, N, Q> {
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> bool {
        let mut is_upright = true;
        let mut collected = Collected::new::<S>(&self.elements.nodes, self.x);
        let mut scattered = Scattered::new(&self.elements.nodes);
        for (batch, points) in self.elements.points.iter().enumerate() {
            let rows = collected.of::<S>(batch);
            scattered.add_last::<S>(batch, self.out);
            for pass in 0..Packs::<S>::PASSES {
                let packs = Packs::new(simd, pass);
                let lame = lame(packs, self.material);
                let edges = edges(packs, rows);
                let mut forces = [[packs.splat(0.0); 3]; N];
                for point in points {
                    let deformed = Deformed::new(packs, &edges, point);
                    is_upright &= !is_inverted(&deformed.f);
                    let weight = packs.load(&point.weight);
                    let p = scale_rows(weight, &self.law.stress(lame, &deformed.at()));
                    for a in 1..N {
                        for i in 0..3 {
                            forces[a][i] = forces[a][i] + dot(p[i], deformed.gradients[a]);
                        }
                    }
                }
                for a in 1..N {
                    forces[0] = sub(forces[0], forces[a]);
                }
                for a in 0..N {
                    packs.spread(&forces[a], &mut scattered.rows[batch % 2][a]);
                }
            }
        }
        scattered.add_last::<S>(self.elements.nodes.len(), self.out);
        is_upright
    }
}

/// True if det F <= 0 in some lane.
#[inline(always)]
fn is_inverted<S: Simd>(f: &Mat3<S>) -> bool {
    (-dot(f[0], cofactor(f)[0])).exceeds(-f64::MIN_POSITIVE)
}

/// Forces on the nodes of every batch, added one batch after they are known: read back at once, they would be shuffled
/// together row by row instead of going through memory.
struct Scattered<'a, const N: usize> {
    nodes: &'a [[[u32; LANES]; N]],
    rows: [[PaddedPoints; N]; 2],
}

impl<'a, const N: usize> Scattered<'a, N> {
    fn new(nodes: &'a [[[u32; LANES]; N]]) -> Self {
        Self { nodes, rows: [[PaddedPoints::ZERO; N]; 2] }
    }

    /// Adds the forces of the batch before `batch`, if there is one.
    #[inline(always)]
    fn add_last<S: Simd>(&self, batch: usize, out: &mut [Padded]) {
        let Some(last) = batch.checked_sub(1) else { return };
        for (nodes, rows) in self.nodes[last].iter().zip(&self.rows[last % 2]) {
            for slot in 0..LANES {
                add(&mut out[nodes[element::<S>(slot)] as usize], &rows.0[slot]);
            }
        }
    }
}

#[inline(always)]
fn add(target: &mut Padded, value: &Padded) {
    for c in 0..4 {
        target[c] += value[c];
    }
}

struct StiffnessKernel<'a, L, const N: usize, const Q: usize> {
    elements: &'a ElementBatch<N, Q>,
    material: &'a Material,
    law: L,
    kind: Tangent,
    x: &'a [Padded],
    map: &'a PairMap,
    blocks: &'a mut [PaddedBlock],
}

impl<L: PointLaw, const N: usize, const Q: usize> WithSimd for StiffnessKernel<'_, L, N, Q> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let n_pairs = N * (N + 1) / 2;
        let mut collected = Collected::new::<S>(&self.elements.nodes, self.x);
        for (batch, points) in self.elements.points.iter().enumerate() {
            let rows = collected.of::<S>(batch);
            let slots = &self.map.slots[batch * n_pairs..(batch + 1) * n_pairs];
            for pass in 0..Packs::<S>::PASSES {
                let packs = Packs::new(simd, pass);
                let lame = lame(packs, self.material);
                let edges = edges(packs, rows);
                for point in points {
                    let deformed = Deformed::new(packs, &edges, point);
                    let mut g = deformed.gradients;
                    let tangent = self.law.tangent(lame, &deformed.at(), self.kind);
                    for a in 1..N {
                        g[0] = sub(g[0], g[a]);
                    }
                    let mut p = g;
                    for a in 0..N {
                        p[a] = apply(&tangent.map, g[a]);
                    }
                    let weight = packs.load(&point.weight);
                    let mut pair = 0;
                    for a in 0..N {
                        for b in 0..=a {
                            let along = tangent.alpha * dot(g[a], g[b]);
                            let mut k = outer_terms(tangent.lambda, tangent.kappa, p[a], p[b], along);
                            if let Some((c, m)) = &tangent.couple {
                                add_couple(&mut k, *c, m, p[a], p[b]);
                            }
                            add_block(packs, &scale_rows(weight, &k), &slots[pair], self.blocks);
                            pair += 1;
                        }
                    }
                }
            }
        }
    }
}

/// `along` 1 + λ p_a p_bᵀ + κ p_b p_aᵀ.
#[inline(always)]
fn outer_terms<S: Simd>(
    lambda: Lanes<S>,
    kappa: Lanes<S>,
    pa: Vec3<S>,
    pb: Vec3<S>,
    along: Lanes<S>,
) -> Mat3<S> {
    let (first, second) = (scale(lambda, pa), scale(kappa, pb));
    let mut k = [[along; 3]; 3];
    for i in 0..3 {
        for j in 0..3 {
            let outer = first[i].mul_add(pb[j], second[i] * pa[j]);
            k[i][j] = if i == j { k[i][j] + outer } else { outer };
        }
    }
    k
}

/// Adds c \[p_a\]× M \[p_b\]×: its column j is c p_a × (M (p_b × e_j)).
#[inline(always)]
fn add_couple<S: Simd>(k: &mut Mat3<S>, c: Lanes<S>, m: &Mat3<S>, pa: Vec3<S>, pb: Vec3<S>) {
    let zero = c.same(0.0);
    let columns = [[zero, pb[2], -pb[1]], [-pb[2], zero, pb[0]], [pb[1], -pb[0], zero]];
    let pa = scale(c, pa);
    for j in 0..3 {
        let column = cross(pa, apply(m, columns[j]));
        for i in 0..3 {
            k[i][j] = k[i][j] + column[i];
        }
    }
}

#[inline(always)]
fn add_block<S: Simd>(packs: Packs<S>, k: &Mat3<S>, slots: &[u32; LANES], blocks: &mut [PaddedBlock]) {
    let mut rows = [PaddedPoints::ZERO; 3];
    for i in 0..3 {
        packs.spread(&k[i], &mut rows[i]);
    }
    for lane in packs.range() {
        let slot = slots[element::<S>(lane)];
        if slot == PairMap::SKIP {
            continue;
        }
        let block = &mut blocks[(slot & !PairMap::TRANSPOSED) as usize];
        for i in 0..3 {
            if slot & PairMap::TRANSPOSED == 0 {
                add(&mut block[i], &rows[i].0[lane]);
            } else {
                for j in 0..3 {
                    block[j][i] += rows[i].0[lane][j];
                }
            }
        }
    }
}
