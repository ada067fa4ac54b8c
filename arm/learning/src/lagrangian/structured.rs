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

use hysteron_learn::{ByParameters, Float, Mlp, MlpTape};

use super::block::{SampleBlock, Term};
use super::factor::Factor;
use super::side::{Side, of_row, put_side_by_side};

/// A potential energy V(q) [J].
#[derive(Debug)]
struct Potential<T> {
    tape: MlpTape<T>,
    scale: T,
    /// A number for every row.
    cotangents: Vec<T>,
}

impl<T: Float> Potential<T> {
    /// Adds ∂_q V to the first numbers of every row of `out` ([row][width]).
    fn add_gradient(&mut self, parameters: &[T], block: &SampleBlock<T>, out: &mut [T]) {
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

/// State shared by both structured terms: factor, potential and intermediate results.
#[derive(Debug)]
struct Energies<T> {
    factor: Factor<T>,
    potential: Potential<T>,
    n_mass: usize,
    /// ε d_i².
    diagonal: Vec<T>,
    along: Vec<T>,
    /// v, the velocities or momenta, and ± v, with the sign that the kinetic energy has.
    v: Vec<Side<T>>,
    signed_v: Vec<Side<T>>,
    /// Lᵀ v.
    pulled: Vec<Side<T>>,
    /// Derivatives of ± ½ |Lᵀ v|² by L.
    by_kinetic: Vec<Side<T>>,
    /// Derivatives of what is learned from, by L and by its tangent along v.
    by_l: [Vec<Side<T>>; 2],
    by_q: Vec<T>,
    /// L u of some u.
    pushed: Vec<Side<T>>,
}

impl<T: Float> Energies<T> {
    fn new(shapes: &EnergyShapes, scales: &EnergyScales) -> Self {
        let [along, by_q] = std::array::from_fn(|_| Vec::new());
        let [v, signed_v, pulled, by_kinetic, pushed] = std::array::from_fn(|_| Vec::new());
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
            v,
            signed_v,
            pulled,
            by_kinetic,
            by_l: [Vec::new(), Vec::new()],
            by_q,
            pushed,
        }
    }

    fn prepare(&mut self, parameters: &[T]) {
        let (mass, potential) = parameters.split_at(self.n_mass);
        self.factor.prepare(mass);
        self.potential.tape.prepare(potential);
    }

    /// Writes `sign` · ∂_q ½ |Lᵀ v|² + ∂_q V to `by_q`.
    fn by_q(&mut self, parameters: &[T], block: &SampleBlock<T>, sign: T) {
        let (n, form) = (block.n_joints, self.factor.form());
        put_side_by_side(&block.v, n, &mut self.v);
        self.signed_v.clear();
        self.signed_v.extend(self.v.iter().map(|v| v.map(|v| sign * v)));
        form.transposed_times([(self.factor.stream(0), &self.v)], &mut self.pulled);
        form.outer_products([(&self.signed_v, &self.pulled)], &mut self.by_kinetic);
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
    /// q̈ and w.
    a: Vec<Side<T>>,
    w: Vec<Side<T>>,
    /// Lᵀq̈ + L̇ᵀq̇.
    accelerated: Vec<Side<T>>,
    /// Lᵀw and L̇ᵀw − L_wᵀq̇.
    by_w: [Vec<Side<T>>; 2],
}

impl<T: Float> StructuredLagrangian<T> {
    pub fn new(shapes: &EnergyShapes, scales: &EnergyScales) -> Self {
        let [a, w, accelerated] = std::array::from_fn(|_| Vec::new());
        Self { energies: Energies::new(shapes, scales), a, w, accelerated, by_w: [Vec::new(), Vec::new()] }
    }

    /// Writes p = H q̇ and ½ ∂_q(q̇ᵀ H q̇) − ∂_q V of every row, [row][joint].
    pub fn momentum(&mut self, parameters: &[T], block: &SampleBlock<T>, momentum: &mut [T], rate: &mut [T]) {
        let e = &mut self.energies;
        let n = block.n_joints;
        e.factor.forward(&parameters[..e.n_mass], &block.features);
        e.by_q(parameters, block, T::of(-1.0));
        e.factor.form().times([(e.factor.stream(0), &e.pulled)], &mut e.pushed);
        for (row, momentum) in momentum.chunks_exact_mut(n).enumerate() {
            let begin = row * n;
            for j in 0..n {
                momentum[j] = e.diagonal[j] * block.v[begin + j] + of_row(&e.pushed, n, row, j);
                rate[begin + j] = -e.by_q[begin + j];
            }
        }
    }
}

impl<T: Float> Term<T> for StructuredLagrangian<T> {
    fn prepare(&mut self, parameters: &[T]) {
        self.energies.prepare(parameters);
    }

    fn outputs(&mut self, parameters: &[T], block: &SampleBlock<T>, out: &mut [T]) {
        let e = &mut self.energies;
        let (n, form) = (block.n_joints, e.factor.form());
        block.features_along(&block.v, &mut e.along);
        e.factor.forward_along(&parameters[..e.n_mass], &block.features, &e.along);
        e.by_q(parameters, block, T::of(-1.0));
        put_side_by_side(&block.a, n, &mut self.a);
        let [l, l_rate] = [0, 1].map(|s| e.factor.stream(s));
        form.transposed_times([(l, &self.a), (l_rate, &e.v)], &mut self.accelerated);
        form.times([(l, &self.accelerated), (l_rate, &e.pulled)], &mut e.pushed);
        for (row, tau) in out.chunks_exact_mut(n).enumerate() {
            let begin = row * n;
            for j in 0..n {
                let rigid = e.by_q[begin + j] + e.diagonal[j] * block.a[begin + j];
                tau[j] = rigid + of_row(&e.pushed, n, row, j);
            }
        }
    }

    fn derivatives(
        &mut self,
        parameters: &[T],
        block: &SampleBlock<T>,
        w: &[T],
        mut into: ByParameters<'_, T>,
    ) {
        let e = &mut self.energies;
        let form = e.factor.form();
        let (mass, potential) = parameters.split_at(e.n_mass);
        block.features_along(w, &mut e.along);
        e.factor.keep(2);
        e.factor.push(mass, &e.along);
        put_side_by_side(w, block.n_joints, &mut self.w);
        let ([l, l_rate, l_w], [lw, rate_w]) = ([0, 1, 2].map(|s| e.factor.stream(s)), &mut self.by_w);
        form.transposed_times([(l, &self.w)], lw);
        form.transposed_times([(l_rate, &self.w), (l_w, &e.signed_v)], rate_w);
        let [by_values, by_rates] = &mut e.by_l;
        form.outer_products([(&self.w, &self.accelerated), (&self.a, lw), (&e.v, rate_w)], by_values);
        form.outer_products([(&self.w, &e.pulled), (&e.v, lw)], by_rates);
        // −v (Lᵀv)ᵀ, the derivative by L_w, is that of −½ |Lᵀv|² by L.
        e.factor.reverse_parameters(mass, [by_values, by_rates], &e.by_kinetic, into.from(0));
        e.potential.derivatives(potential, &e.along, into.from(e.n_mass));
    }
}

/// τ and q̇ of a structured Hamiltonian ½ pᵀ A p + V with A = L Lᵀ + ε I, the inverse of the mass matrix:
/// τ = ṗ + ∂_q ½ |Lᵀ p|² + ∂_q V, q̇ = A p.
#[derive(Debug)]
pub(crate) struct StructuredHamiltonian<T> {
    energies: Energies<T>,
    /// Weights of τ, then of q̇, in w · (τ, q̇): [row][joint]; `by_speed` holds those of q̇.
    of_w: Vec<T>,
    by_speed: Vec<Side<T>>,
    /// L_wᵀp + Lᵀu, u of the speeds.
    pulled: Vec<Side<T>>,
}

impl<T: Float> StructuredHamiltonian<T> {
    pub fn new(shapes: &EnergyShapes, scales: &EnergyScales) -> Self {
        let [by_speed, pulled] = std::array::from_fn(|_| Vec::new());
        Self { energies: Energies::new(shapes, scales), of_w: Vec::new(), by_speed, pulled }
    }
}

impl<T: Float> Term<T> for StructuredHamiltonian<T> {
    fn prepare(&mut self, parameters: &[T]) {
        self.energies.prepare(parameters);
    }

    fn outputs(&mut self, parameters: &[T], block: &SampleBlock<T>, out: &mut [T]) {
        let e = &mut self.energies;
        let n = block.n_joints;
        e.factor.forward(&parameters[..e.n_mass], &block.features);
        e.by_q(parameters, block, T::of(1.0));
        e.factor.form().times([(e.factor.stream(0), &e.pulled)], &mut e.pushed);
        for (row, out) in out.chunks_exact_mut(2 * n).enumerate() {
            let begin = row * n;
            let (tau, speed) = out.split_at_mut(n);
            for j in 0..n {
                tau[j] = block.a[begin + j] + e.by_q[begin + j];
                speed[j] = e.diagonal[j] * block.v[begin + j] + of_row(&e.pushed, n, row, j);
            }
        }
    }

    fn derivatives(
        &mut self,
        parameters: &[T],
        block: &SampleBlock<T>,
        w: &[T],
        mut into: ByParameters<'_, T>,
    ) {
        let e = &mut self.energies;
        let (n, form) = (block.n_joints, e.factor.form());
        let (mass, potential) = parameters.split_at(e.n_mass);
        let of_kind = |k: usize| w.chunks_exact(n).skip(k).step_by(2).flatten().copied();
        self.of_w.clear();
        self.of_w.extend(of_kind(0));
        block.features_along(&self.of_w, &mut e.along);
        e.factor.keep(1);
        e.factor.push(mass, &e.along);
        self.of_w.clear();
        self.of_w.extend(of_kind(1));
        put_side_by_side(&self.of_w, n, &mut self.by_speed);
        let [l, l_w] = [0, 1].map(|s| e.factor.stream(s));
        form.transposed_times([(l_w, &e.v), (l, &self.by_speed)], &mut self.pulled);
        let [by_l, _] = &mut e.by_l;
        form.outer_products([(&e.v, &self.pulled), (&self.by_speed, &e.pulled)], by_l);
        // p (Lᵀp)ᵀ, the derivative by L_w, is that of ½ |Lᵀp|² by L.
        e.factor.reverse_parameters(mass, [by_l], &e.by_kinetic, into.from(0));
        e.potential.derivatives(potential, &e.along, into.from(e.n_mass));
    }
}
