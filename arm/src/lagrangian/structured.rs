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

use super::MOST_WIDTH;
use super::block::{Block, Term};
use super::factor::{Factor, add_times, outer_products, transposed_times};

/// A potential energy V(q) [J].
#[derive(Debug)]
struct Potential<T> {
    tape: MlpTape<T>,
    scale: T,
    /// A number for every row.
    cotangents: Vec<T>,
}

impl<T: Real> Potential<T> {
    /// Adds ∂_q V to the first numbers of every row of `out` ([row][width]).
    fn add_gradient(&mut self, parameters: &[T], block: &Block<T>, out: &mut [T]) {
        self.tape.forward(parameters, &block.features);
        self.cotangents.clear();
        self.cotangents.resize(block.n_rows, self.scale);
        let by_features = self.tape.reverse_inputs(parameters, &self.cotangents);
        block.add_by_q(by_features, block.n_features(), T::of(1.0), out);
    }

    /// Adds the derivatives of D_w V by the parameters, after the gradient; `along` are the features' derivatives along w.
    fn derivatives(&mut self, parameters: &[T], along: &[T], into: ByParameters<'_, T>) {
        self.tape.keep(1);
        self.tape.push_tangent(parameters, along);
        self.cotangents.fill(T::default());
        self.tape.reverse_parameters_repeating(parameters, &self.cotangents, into);
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
    /// Lᵀ v of every row, v the velocities or momenta.
    pulled: Vec<T>,
    /// Derivatives of ± ½ |Lᵀ v|² by L.
    by_kinetic: Vec<T>,
    /// Derivatives of what is learned from, by L and by its tangent along v.
    by_l: [Vec<T>; 2],
    by_q: Vec<T>,
}

impl<T: Real> Energies<T> {
    fn new(shapes: &EnergyShapes, scales: &EnergyScales) -> Self {
        let [along, pulled, by_kinetic, by_q] = std::array::from_fn(|_| Vec::new());
        let potential = Potential {
            tape: MlpTape::new(&shapes.potential),
            scale: T::of(scales.potential),
            cotangents: Vec::new(),
        };
        Self {
            factor: Factor::new(&shapes.mass, &scales.factor),
            potential,
            n_mass: shapes.mass.n_parameters(),
            diagonal: scales.factor.iter().map(|d| T::of(scales.epsilon * d * d)).collect(),
            along,
            pulled,
            by_kinetic,
            by_l: [Vec::new(), Vec::new()],
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
        let (n, len, width) = (block.n_joints, self.factor.len(), self.factor.width());
        self.pulled.resize(block.n_rows * width, T::default());
        self.by_kinetic.resize(block.n_rows * len, T::default());
        let mut signed = [T::default(); MOST_WIDTH];
        let rows = self.pulled.chunks_exact_mut(width).zip(self.by_kinetic.chunks_exact_mut(len));
        for (row, (pulled, by_l)) in rows.enumerate() {
            let v = &block.v[row * n..(row + 1) * n];
            transposed_times(self.factor.row(0, row), v, pulled);
            for (signed, c) in signed.iter_mut().zip(&*pulled) {
                *signed = sign * *c;
            }
            outer_products(by_l, [(v, &signed[..width])]);
        }
        self.by_q.clear();
        self.by_q.resize(block.n_rows * n, T::default());
        let (mass, potential) = parameters.split_at(self.n_mass);
        let by_features = self.factor.reverse_features(mass, &self.by_kinetic);
        block.add_by_q(by_features, block.n_features(), T::of(1.0), &mut self.by_q);
        self.potential.add_gradient(potential, block, &mut self.by_q);
    }
}

/// τ of a structured Lagrangian.
#[derive(Debug)]
pub(crate) struct StructuredLagrangian<T> {
    energies: Energies<T>,
    /// Lᵀq̈ + L̇ᵀq̇ of every row.
    accelerated: Vec<T>,
}

impl<T: Real> StructuredLagrangian<T> {
    pub fn new(shapes: &EnergyShapes, scales: &EnergyScales) -> Self {
        Self { energies: Energies::new(shapes, scales), accelerated: Vec::new() }
    }

    /// Writes p = H q̇ and ½ ∂_q(q̇ᵀ H q̇) − ∂_q V of every row, [row][joint].
    pub fn momentum(&mut self, parameters: &[T], block: &Block<T>, momentum: &mut [T], rate: &mut [T]) {
        let e = &mut self.energies;
        let (n, width) = (block.n_joints, e.factor.width());
        e.factor.forward(&parameters[..e.n_mass], &block.features);
        e.by_q(parameters, block, T::of(-1.0));
        for (row, momentum) in momentum.chunks_exact_mut(n).enumerate() {
            let begin = row * n;
            for j in 0..n {
                momentum[j] = e.diagonal[j] * block.v[begin + j];
                rate[begin + j] = -e.by_q[begin + j];
            }
            add_times(e.factor.row(0, row), &e.pulled[row * width..][..width], momentum);
        }
    }
}

impl<T: Real> Term<T> for StructuredLagrangian<T> {
    fn prepare(&mut self, parameters: &[T]) {
        self.energies.prepare(parameters);
    }

    fn outputs(&mut self, parameters: &[T], block: &Block<T>, out: &mut [T]) {
        let e = &mut self.energies;
        let (n, width) = (block.n_joints, e.factor.width());
        block.features_along(&block.v, &mut e.along);
        e.factor.forward_along(&parameters[..e.n_mass], &block.features, &e.along);
        e.by_q(parameters, block, T::of(-1.0));
        self.accelerated.resize(block.n_rows * width, T::default());
        let mut rate = [T::default(); MOST_WIDTH];
        let rows = out.chunks_exact_mut(n).zip(self.accelerated.chunks_exact_mut(width));
        for (row, (tau, accelerated)) in rows.enumerate() {
            let part = row * n..(row + 1) * n;
            let (v, a) = (&block.v[part.clone()], &block.a[part.clone()]);
            let (l, l_rate) = (e.factor.row(0, row), e.factor.row(1, row));
            transposed_times(l, a, accelerated);
            transposed_times(l_rate, v, &mut rate[..width]);
            for (sum, rate) in accelerated.iter_mut().zip(&rate) {
                *sum += *rate;
            }
            for j in 0..n {
                tau[j] = e.by_q[part.start + j] + e.diagonal[j] * a[j];
            }
            add_times(l, accelerated, tau);
            add_times(l_rate, &e.pulled[row * width..][..width], tau);
        }
    }

    fn derivatives(&mut self, parameters: &[T], block: &Block<T>, w: &[T], mut into: ByParameters<'_, T>) {
        let e = &mut self.energies;
        let (n, len, width) = (block.n_joints, e.factor.len(), e.factor.width());
        let (mass, potential) = parameters.split_at(e.n_mass);
        block.features_along(w, &mut e.along);
        e.factor.keep(2);
        e.factor.push(mass, &e.along);
        for by_l in &mut e.by_l {
            by_l.resize(block.n_rows * len, T::default());
        }
        let [by_values, by_rates] = &mut e.by_l;
        let [mut lw, mut rate_w, mut w_v] = [[T::default(); MOST_WIDTH]; 3];
        let [lw, rate_w, w_v] = [&mut lw[..width], &mut rate_w[..width], &mut w_v[..width]];
        let rows = by_values.chunks_exact_mut(len).zip(by_rates.chunks_exact_mut(len));
        for (row, (by_values, by_rates)) in rows.enumerate() {
            let [v, a, w] = [&block.v, &block.a, w].map(|values| &values[row * n..(row + 1) * n]);
            let [lv, accelerated] = [&e.pulled, &self.accelerated].map(|c| &c[row * width..][..width]);
            let [l, l_rate, l_w] = [0, 1, 2].map(|s| e.factor.row(s, row));
            transposed_times(l, w, lw);
            transposed_times(l_rate, w, rate_w);
            transposed_times(l_w, v, w_v);
            for (sum, w_v) in rate_w.iter_mut().zip(&*w_v) {
                *sum -= *w_v;
            }
            outer_products(by_values, [(w, accelerated), (a, lw), (v, rate_w)]);
            outer_products(by_rates, [(w, lv), (v, lw)]);
        }
        // −v (Lᵀv)ᵀ, the derivative by L_w, is that of −½ |Lᵀv|² by L.
        e.factor.reverse_parameters(mass, [by_values, by_rates], &e.by_kinetic, into.from(0));
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
        let (n, width) = (block.n_joints, e.factor.width());
        e.factor.forward(&parameters[..e.n_mass], &block.features);
        e.by_q(parameters, block, T::of(1.0));
        for (row, out) in out.chunks_exact_mut(2 * n).enumerate() {
            let part = row * n..(row + 1) * n;
            let p = &block.v[part.clone()];
            let (tau, speed) = out.split_at_mut(n);
            for j in 0..n {
                tau[j] = block.a[part.start + j] + e.by_q[part.start + j];
                speed[j] = e.diagonal[j] * p[j];
            }
            add_times(e.factor.row(0, row), &e.pulled[row * width..][..width], speed);
        }
    }

    fn derivatives(&mut self, parameters: &[T], block: &Block<T>, w: &[T], mut into: ByParameters<'_, T>) {
        let e = &mut self.0;
        let (n, len, width) = (block.n_joints, e.factor.len(), e.factor.width());
        let (mass, potential) = parameters.split_at(e.n_mass);
        let torques: Vec<T> = w.chunks_exact(2 * n).flat_map(|w| w[..n].to_vec()).collect();
        block.features_along(&torques, &mut e.along);
        e.factor.keep(1);
        e.factor.push(mass, &e.along);
        let by_l = &mut e.by_l[0];
        by_l.resize(block.n_rows * len, T::default());
        let [mut c_w, mut c_u] = [[T::default(); MOST_WIDTH]; 2];
        let [c_w, c_u] = [&mut c_w[..width], &mut c_u[..width]];
        for (row, by_l) in by_l.chunks_exact_mut(len).enumerate() {
            let p = &block.v[row * n..(row + 1) * n];
            let u = &w[row * 2 * n + n..(row + 1) * 2 * n];
            let (l, l_w) = (e.factor.row(0, row), e.factor.row(1, row));
            transposed_times(l_w, p, c_w);
            transposed_times(l, u, c_u);
            for (sum, c_u) in c_w.iter_mut().zip(&*c_u) {
                *sum += *c_u;
            }
            outer_products(by_l, [(p, c_w), (u, &e.pulled[row * width..][..width])]);
        }
        // p (Lᵀp)ᵀ, the derivative by L_w, is that of ½ |Lᵀp|² by L.
        e.factor.reverse_parameters(mass, [by_l], &e.by_kinetic, into.from(0));
        e.potential.derivatives(potential, &e.along, into.from(e.n_mass));
    }
}
