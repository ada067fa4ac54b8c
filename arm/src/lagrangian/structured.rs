//! Structured energies: a mass matrix (or its inverse) by its factor, and a potential.
//!
//! Torque of the Lagrangian ½ q̇ᵀ H q̇ − V with H = L Lᵀ + ε I, from L, its derivative L̇ along q̇ and one reverse pass each:
//!
//! ```text
//! τ = L (Lᵀ q̈ + L̇ᵀ q̇) + L̇ Lᵀ q̇ + ε q̈ − ∂_q ½ |Lᵀ q̇|² + ∂_q V
//! ```
//!
//! and for a constant w, with L_w the derivative of L along w,
//!
//! ```text
//! wᵀ τ = Lᵀw · (Lᵀq̈ + L̇ᵀq̇) + L̇ᵀw · Lᵀq̇ − L_wᵀq̇ · Lᵀq̇ + D_w V + ε w · q̈,
//! ```
//!
//! whose derivatives by L, L̇ and L_w are outer products: one reverse pass through value and two tangents.

use hysteron_learn::{ByParameters, Mlp, MlpTape, Real};

use super::block::{Block, Term};
use super::factor::{Factor, add_outer, add_times, transposed_times};

/// A potential energy V(q) [J].
#[derive(Debug)]
struct Potential<T> {
    tape: MlpTape<T>,
    scale: T,
    ones: Vec<T>,
}

impl<T: Real> Potential<T> {
    /// Adds ∂_q V to the first numbers of every row of `out` ([row][width]).
    fn add_gradient(&mut self, parameters: &[T], block: &Block<T>, out: &mut [T]) {
        self.tape.forward(parameters, &block.features);
        self.ones.clear();
        self.ones.resize(block.n_rows, T::of(1.0));
        let by_features = self.tape.reverse_inputs(parameters, &self.ones);
        block.add_by_q(by_features, block.n_features(), self.scale, out);
    }

    /// Adds the derivatives of D_w V by the parameters; `along` are the features' derivatives along w.
    fn derivatives(&mut self, parameters: &[T], along: &[T], into: ByParameters<'_, T>) {
        self.tape.keep(1);
        self.tape.push_tangent(parameters, along);
        let n_rows = self.ones.len();
        self.ones.fill(T::default());
        self.ones.resize(2 * n_rows, self.scale);
        self.tape.reverse_parameters(parameters, &self.ones, into);
        self.ones.truncate(n_rows);
    }
}

/// How energies are measured.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct EnergyScales {
    /// d_i of every joint: L is d_i times a number of order 1 [√(kg m²), or its inverse for an inverse mass].
    pub factor: Vec<f64>,
    /// Of the potential [J].
    pub potential: f64,
    /// ε of H, of order 1: the matrix gets ε d_i² on its diagonal [-].
    pub epsilon: f64,
}

/// Shapes of the two networks.
#[derive(Debug, Clone)]
pub(crate) struct EnergyShapes {
    pub mass: Mlp,
    pub potential: Mlp,
}

/// What both structured terms share.
#[derive(Debug)]
struct Energies<T> {
    factor: Factor<T>,
    potential: Potential<T>,
    n_mass: usize,
    /// ε d_i².
    diagonal: Vec<T>,
    along: Vec<T>,
    by_l: Vec<T>,
    by_q: Vec<T>,
}

impl<T: Real> Energies<T> {
    fn new(shapes: &EnergyShapes, scales: &EnergyScales) -> Self {
        let [along, by_l, by_q] = std::array::from_fn(|_| Vec::new());
        let potential = Potential {
            tape: MlpTape::new(&shapes.potential),
            scale: T::of(scales.potential),
            ones: Vec::new(),
        };
        Self {
            factor: Factor::new(&shapes.mass, &scales.factor),
            potential,
            n_mass: shapes.mass.n_parameters(),
            diagonal: scales.factor.iter().map(|d| T::of(scales.epsilon * d * d)).collect(),
            along,
            by_l,
            by_q,
        }
    }

    fn prepare(&mut self, parameters: &[T]) {
        let (mass, potential) = parameters.split_at(self.n_mass);
        self.factor.prepare(mass);
        self.potential.tape.prepare(potential);
    }

    /// Adds `sign` · ∂_q ½ |Lᵀ v|² + ∂_q V to `by_q`, which is set to zero first.
    fn by_q(&mut self, parameters: &[T], block: &Block<T>, sign: T) {
        let (n, m, columns) = (block.n_joints, self.factor.len(), self.factor.columns());
        self.by_l.clear();
        self.by_l.resize(block.n_rows * m, T::default());
        let mut c = [T::default(); super::MOST_COLUMNS];
        for (row, by_l) in self.by_l.chunks_exact_mut(m).enumerate() {
            let v = &block.v[row * n..(row + 1) * n];
            transposed_times(self.factor.row(0, row), v, &mut c[..columns]);
            add_outer(by_l, sign, v, &c[..columns]);
        }
        self.by_q.clear();
        self.by_q.resize(block.n_rows * n, T::default());
        let (mass, potential) = parameters.split_at(self.n_mass);
        let by_features = self.factor.reverse_features(mass, &self.by_l);
        block.add_by_q(by_features, block.n_features(), T::of(1.0), &mut self.by_q);
        self.potential.add_gradient(potential, block, &mut self.by_q);
    }
}

/// τ of a structured Lagrangian.
#[derive(Debug)]
pub(crate) struct StructuredLagrangian<T>(Energies<T>);

impl<T: Real> StructuredLagrangian<T> {
    pub fn new(shapes: &EnergyShapes, scales: &EnergyScales) -> Self {
        Self(Energies::new(shapes, scales))
    }

    /// Writes p = H q̇ and ½ ∂_q(q̇ᵀ H q̇) − ∂_q V of every row, [row][joint].
    pub fn momentum(&mut self, parameters: &[T], block: &Block<T>, momentum: &mut [T], rate: &mut [T]) {
        let e = &mut self.0;
        let (n, columns) = (block.n_joints, e.factor.columns());
        e.factor.forward(&parameters[..e.n_mass], &block.features);
        e.by_q(parameters, block, T::of(-1.0));
        let mut c = [T::default(); super::MOST_COLUMNS];
        for (row, momentum) in momentum.chunks_exact_mut(n).enumerate() {
            let part = row * n..(row + 1) * n;
            let l = e.factor.row(0, row);
            transposed_times(l, &block.v[part.clone()], &mut c[..columns]);
            for j in 0..n {
                momentum[j] = e.diagonal[j] * block.v[part.start + j];
                rate[part.start + j] = -e.by_q[part.start + j];
            }
            add_times(l, &c[..columns], momentum);
        }
    }
}

impl<T: Real> Term<T> for StructuredLagrangian<T> {
    fn prepare(&mut self, parameters: &[T]) {
        self.0.prepare(parameters);
    }

    fn outputs(&mut self, parameters: &[T], block: &Block<T>, out: &mut [T]) {
        let e = &mut self.0;
        let (n, columns) = (block.n_joints, e.factor.columns());
        block.features_along(&block.v, &mut e.along);
        e.factor.forward_along(&parameters[..e.n_mass], &block.features, &e.along);
        e.by_q(parameters, block, T::of(-1.0));
        let [mut sum, mut c, mut rate] = [[T::default(); super::MOST_COLUMNS]; 3];
        for (row, tau) in out.chunks_exact_mut(n).enumerate() {
            let part = row * n..(row + 1) * n;
            let (v, a) = (&block.v[part.clone()], &block.a[part.clone()]);
            let (l, l_rate) = (e.factor.row(0, row), e.factor.row(1, row));
            transposed_times(l, a, &mut sum[..columns]);
            transposed_times(l, v, &mut c[..columns]);
            transposed_times(l_rate, v, &mut rate[..columns]);
            for k in 0..columns {
                sum[k] += rate[k];
            }
            for j in 0..n {
                tau[j] = e.by_q[part.start + j] + e.diagonal[j] * a[j];
            }
            add_times(l, &sum[..columns], tau);
            add_times(l_rate, &c[..columns], tau);
        }
    }

    fn derivatives(&mut self, parameters: &[T], block: &Block<T>, w: &[T], mut into: ByParameters<'_, T>) {
        let e = &mut self.0;
        let (n, m, columns) = (block.n_joints, e.factor.len(), e.factor.columns());
        let (mass, potential) = parameters.split_at(e.n_mass);
        block.features_along(w, &mut e.along);
        e.factor.keep(2);
        e.factor.push(mass, &e.along);
        let len = block.n_rows * m;
        e.by_l.clear();
        e.by_l.resize(3 * len, T::default());
        let (value, tangents) = e.by_l.split_at_mut(len);
        let (along_v, along_w) = tangents.split_at_mut(len);
        let one = T::of(1.0);
        let [mut lw, mut la, mut lv, mut rate_w, mut rate_v, mut w_v] =
            [[T::default(); super::MOST_COLUMNS]; 6];
        for row in 0..block.n_rows {
            let part = row * n..(row + 1) * n;
            let (v, a, w) = (&block.v[part.clone()], &block.a[part.clone()], &w[part]);
            let [l, l_rate, l_w] = [0, 1, 2].map(|s| e.factor.row(s, row));
            transposed_times(l, w, &mut lw[..columns]);
            transposed_times(l, a, &mut la[..columns]);
            transposed_times(l, v, &mut lv[..columns]);
            transposed_times(l_rate, w, &mut rate_w[..columns]);
            transposed_times(l_rate, v, &mut rate_v[..columns]);
            transposed_times(l_w, v, &mut w_v[..columns]);
            let packed_row = row * m..(row + 1) * m;
            let by_l = &mut value[packed_row.clone()];
            for k in 0..columns {
                la[k] += rate_v[k];
                rate_w[k] -= w_v[k];
            }
            add_outer(by_l, one, w, &la[..columns]);
            add_outer(by_l, one, a, &lw[..columns]);
            add_outer(by_l, one, v, &rate_w[..columns]);
            let by_rate = &mut along_v[packed_row.clone()];
            add_outer(by_rate, one, w, &lv[..columns]);
            add_outer(by_rate, one, v, &lw[..columns]);
            add_outer(&mut along_w[packed_row], -one, v, &lv[..columns]);
        }
        e.factor.reverse_parameters(mass, &e.by_l, into.from(0));
        e.potential.derivatives(potential, &e.along, into.from(e.n_mass));
    }
}

/// τ and q̇ of a structured Hamiltonian ½ pᵀ A p + V with A = L Lᵀ + ε I, the inverse of the mass matrix:
/// τ = ṗ + ∂_q ½ |Lᵀ p|² + ∂_q V, q̇ = A p.
#[derive(Debug)]
pub(crate) struct StructuredHamiltonian<T>(Energies<T>);

impl<T: Real> StructuredHamiltonian<T> {
    pub fn new(shapes: &EnergyShapes, scales: &EnergyScales) -> Self {
        Self(Energies::new(shapes, scales))
    }
}

impl<T: Real> Term<T> for StructuredHamiltonian<T> {
    fn prepare(&mut self, parameters: &[T]) {
        self.0.prepare(parameters);
    }

    fn outputs(&mut self, parameters: &[T], block: &Block<T>, out: &mut [T]) {
        let e = &mut self.0;
        let (n, columns) = (block.n_joints, e.factor.columns());
        e.factor.forward(&parameters[..e.n_mass], &block.features);
        e.by_q(parameters, block, T::of(1.0));
        let mut c = [T::default(); super::MOST_COLUMNS];
        for (row, out) in out.chunks_exact_mut(2 * n).enumerate() {
            let part = row * n..(row + 1) * n;
            let p = &block.v[part.clone()];
            let l = e.factor.row(0, row);
            transposed_times(l, p, &mut c[..columns]);
            let (tau, speed) = out.split_at_mut(n);
            for j in 0..n {
                tau[j] = block.a[part.start + j] + e.by_q[part.start + j];
                speed[j] = e.diagonal[j] * p[j];
            }
            add_times(l, &c[..columns], speed);
        }
    }

    fn derivatives(&mut self, parameters: &[T], block: &Block<T>, w: &[T], mut into: ByParameters<'_, T>) {
        let e = &mut self.0;
        let (n, m, columns) = (block.n_joints, e.factor.len(), e.factor.columns());
        let (mass, potential) = parameters.split_at(e.n_mass);
        let torques: Vec<T> = w.chunks_exact(2 * n).flat_map(|w| w[..n].to_vec()).collect();
        block.features_along(&torques, &mut e.along);
        e.factor.keep(1);
        e.factor.push(mass, &e.along);
        let len = block.n_rows * m;
        e.by_l.clear();
        e.by_l.resize(2 * len, T::default());
        let (value, along_w) = e.by_l.split_at_mut(len);
        let one = T::of(1.0);
        let [mut c, mut c_w, mut c_u] = [[T::default(); super::MOST_COLUMNS]; 3];
        for row in 0..block.n_rows {
            let p = &block.v[row * n..(row + 1) * n];
            let u = &w[row * 2 * n + n..(row + 1) * 2 * n];
            let (l, l_w) = (e.factor.row(0, row), e.factor.row(1, row));
            transposed_times(l, p, &mut c[..columns]);
            transposed_times(l_w, p, &mut c_w[..columns]);
            transposed_times(l, u, &mut c_u[..columns]);
            for k in 0..columns {
                c_w[k] += c_u[k];
            }
            let by_l = &mut value[row * m..(row + 1) * m];
            add_outer(by_l, one, p, &c_w[..columns]);
            add_outer(by_l, one, u, &c[..columns]);
            add_outer(&mut along_w[row * m..(row + 1) * m], one, p, &c[..columns]);
        }
        e.factor.reverse_parameters(mass, &e.by_l, into.from(0));
        e.potential.derivatives(potential, &e.along, into.from(e.n_mass));
    }
}
