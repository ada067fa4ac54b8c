//! Energies of one network, and torques of one.
//!
//! Lagrangian ℒ(q, q̇): with a = (q̇, q̈), b = (0, w), c = (w, 0) as directions of (q, q̇), τ = ∂_q̇ D_a ℒ − ∂_q ℒ (a held
//! constant) and wᵀ τ = D_a D_b ℒ − D_c ℒ. Hamiltonian ℋ(q, p): τ = ṗ + ∂_q ℋ, q̇ = ∂_p ℋ. Feed-forward: τ = f(q, q̇, q̈).

use hysteron_learn::{ByParameters, Float, Mlp, MlpTape};

use super::block::{SampleBlock, Term};

/// Features, then further columns, row by row.
fn join<T: Float>(features: &[T], width: usize, columns: &[(&[T], &[T])], out: &mut Vec<T>) {
    out.clear();
    for (row, features) in features.chunks_exact(width).enumerate() {
        out.extend_from_slice(features);
        for (values, factors) in columns {
            let n = factors.len();
            out.extend(values[row * n..(row + 1) * n].iter().zip(*factors).map(|(v, f)| *v * *f));
        }
    }
}

/// Inputs of an energy from velocities or momenta v: each in units of its spread, and, with products, those
/// of every pair.
#[derive(Debug)]
struct Speeds<T> {
    /// 1/σ of every one.
    per_speed: Vec<T>,
    has_products: bool,
}

impl<T: Float> Speeds<T> {
    /// Calls with i, j and 1/(σ_i σ_j) of every product.
    fn products(&self, mut call: impl FnMut(usize, usize, T)) {
        let n = if self.has_products { self.per_speed.len() } else { 0 };
        for i in 0..n {
            for j in i..n {
                call(i, j, self.per_speed[i] * self.per_speed[j]);
            }
        }
    }

    fn append(&self, v: &[T], out: &mut Vec<T>) {
        out.extend(v.iter().zip(&self.per_speed).map(|(v, f)| *v * *f));
        self.products(|i, j, factor| out.push(v[i] * v[j] * factor));
    }

    /// Their derivatives at `v` along `dv`.
    fn append_along(&self, v: &[T], dv: &[T], out: &mut Vec<T>) {
        out.extend(dv.iter().zip(&self.per_speed).map(|(v, f)| *v * *f));
        self.products(|i, j, factor| out.push((v[i] * dv[j] + dv[i] * v[j]) * factor));
    }

    /// The derivatives by `v` of what has these by what is seen of them.
    fn back(&self, v: &[T], by_seen: &[T], out: &mut [T]) {
        for (out, (by, f)) in out.iter_mut().zip(by_seen.iter().zip(&self.per_speed)) {
            *out = *by * *f;
        }
        let mut by_products = by_seen[self.per_speed.len()..].iter();
        self.products(|i, j, factor| {
            let by = by_products.next().map_or(T::default(), |by| *by * factor);
            out[i] += by * v[j];
            out[j] += by * v[i];
        });
    }
}

/// An energy of (q, v) and what it needs for its derivatives.
#[derive(Debug)]
struct BlackBoxEnergy<T> {
    tape: MlpTape<T>,
    width: usize,
    speeds: Speeds<T>,
    /// Of the energy [J].
    scale: T,
    inputs: Vec<T>,
    along: Vec<T>,
    cotangents: Vec<T>,
    zeros: Vec<T>,
}

impl<T: Float> BlackBoxEnergy<T> {
    fn new(mlp: &Mlp, (speeds, has_products): (&[f64], bool), scale: f64) -> Self {
        let [inputs, along, cotangents, zeros] = std::array::from_fn(|_| Vec::new());
        let per_speed = speeds.iter().map(|s| T::of(1.0 / s)).collect();
        Self {
            tape: MlpTape::new(mlp),
            width: mlp.inputs,
            speeds: Speeds { per_speed, has_products },
            scale: T::of(scale),
            inputs,
            along,
            cotangents,
            zeros,
        }
    }

    fn forward(&mut self, parameters: &[T], block: &SampleBlock<T>) {
        let rows = block.features.chunks_exact(block.n_features()).zip(block.v.chunks_exact(block.n_joints));
        self.inputs.clear();
        for (features, v) in rows {
            self.inputs.extend_from_slice(features);
            self.speeds.append(v, &mut self.inputs);
        }
        self.tape.forward(parameters, &self.inputs);
    }

    /// One more stream along (dq, dv).
    fn push(&mut self, parameters: &[T], block: &SampleBlock<T>, dq: &[T], dv: &[T]) {
        block.features_along(dq, &mut self.along);
        let n = block.n_joints;
        let motion = block.v.chunks_exact(n).zip(dv.chunks_exact(n));
        self.inputs.clear();
        for (along, (v, dv)) in self.along.chunks_exact(block.n_features()).zip(motion) {
            self.inputs.extend_from_slice(along);
            self.speeds.append_along(v, dv, &mut self.inputs);
        }
        self.tape.push_tangent(parameters, &self.inputs);
    }

    /// Cotangents of single outputs: one number for each stream.
    fn cotangents(&mut self, n_rows: usize, streams: &[f64]) {
        self.cotangents.clear();
        for value in streams {
            let value = T::of(*value) * self.scale;
            self.cotangents.resize(self.cotangents.len() + n_rows, value);
        }
    }
}

/// τ of a Lagrangian that is one network.
#[derive(Debug)]
pub(crate) struct BlackBoxLagrangian<T>(BlackBoxEnergy<T>);

impl<T: Float> BlackBoxLagrangian<T> {
    pub fn new(mlp: &Mlp, speeds: &[f64], scale: f64) -> Self {
        Self(BlackBoxEnergy::new(mlp, (speeds, false), scale))
    }
}

impl<T: Float> Term<T> for BlackBoxLagrangian<T> {
    fn prepare(&mut self, parameters: &[T]) {
        self.0.tape.prepare(parameters);
    }

    fn outputs(&mut self, parameters: &[T], block: &SampleBlock<T>, out: &mut [T]) {
        let n = block.n_joints;
        let e = &mut self.0;
        e.forward(parameters, block);
        e.push(parameters, block, &block.v, &block.a);
        e.cotangents(block.n_rows, &[0.0, 1.0]);
        let by_inputs = e.tape.reverse_inputs(parameters, &e.cotangents);
        let rows = by_inputs.chunks_exact(e.width).zip(block.v.chunks_exact(n));
        for (tau, (by_inputs, v)) in out.chunks_exact_mut(n).zip(rows) {
            e.speeds.back(v, &by_inputs[block.n_features()..], tau);
        }
        e.cotangents(block.n_rows, &[1.0]);
        let by_inputs = e.tape.reverse_inputs(parameters, &e.cotangents);
        block.add_by_q(by_inputs, e.width, T::of(-1.0), out);
    }

    fn derivatives(&mut self, parameters: &[T], block: &SampleBlock<T>, w: &[T], into: ByParameters<'_, T>) {
        let e = &mut self.0;
        let mut zeros = std::mem::take(&mut e.zeros);
        zeros.resize(w.len(), T::default());
        e.tape.keep(2);
        e.push(parameters, block, &zeros, w);
        e.tape.push_mixed(parameters, 1, 2);
        e.push(parameters, block, w, &zeros);
        e.zeros = zeros;
        e.cotangents(block.n_rows, &[0.0, 0.0, 0.0, 1.0, -1.0]);
        e.tape.reverse_parameters(parameters, &e.cotangents, into);
    }
}

/// τ and q̇ of a Hamiltonian that is one network.
#[derive(Debug)]
pub(crate) struct BlackBoxHamiltonian<T>(BlackBoxEnergy<T>);

impl<T: Float> BlackBoxHamiltonian<T> {
    /// It sees the products of every two momenta where it `has_products`.
    pub fn new(mlp: &Mlp, (momenta, has_products): (&[f64], bool), scale: f64) -> Self {
        Self(BlackBoxEnergy::new(mlp, (momenta, has_products), scale))
    }
}

impl<T: Float> Term<T> for BlackBoxHamiltonian<T> {
    fn prepare(&mut self, parameters: &[T]) {
        self.0.tape.prepare(parameters);
    }

    fn outputs(&mut self, parameters: &[T], block: &SampleBlock<T>, out: &mut [T]) {
        let n = block.n_joints;
        let e = &mut self.0;
        e.forward(parameters, block);
        e.cotangents(block.n_rows, &[1.0]);
        let by_inputs = e.tape.reverse_inputs(parameters, &e.cotangents);
        for (row, (out, by_inputs)) in
            out.chunks_exact_mut(2 * n).zip(by_inputs.chunks_exact(e.width)).enumerate()
        {
            let (tau, speed) = out.split_at_mut(n);
            tau.copy_from_slice(&block.a[row * n..(row + 1) * n]);
            block.add_row_by_q(row, by_inputs, T::of(1.0), tau);
            let v = &block.v[row * n..(row + 1) * n];
            e.speeds.back(v, &by_inputs[block.n_features()..], speed);
        }
    }

    fn derivatives(&mut self, parameters: &[T], block: &SampleBlock<T>, w: &[T], into: ByParameters<'_, T>) {
        let n = block.n_joints;
        let e = &mut self.0;
        let torques: Vec<T> = w.chunks_exact(2 * n).flat_map(|w| w[..n].to_vec()).collect();
        let speeds: Vec<T> = w.chunks_exact(2 * n).flat_map(|w| w[n..].to_vec()).collect();
        e.tape.keep(1);
        e.push(parameters, block, &torques, &speeds);
        e.cotangents(block.n_rows, &[0.0, 1.0]);
        e.tape.reverse_parameters(parameters, &e.cotangents, into);
    }
}

/// Torques of a network of (q, q̇, q̈): the feed-forward baseline, and the unmodelled torque ε of (8).
#[derive(Debug)]
pub(crate) struct FeedForward<T> {
    tape: MlpTape<T>,
    per_speed: Vec<T>,
    per_acceleration: Vec<T>,
    /// Of the torques [N m].
    torque: Vec<T>,
    inputs: Vec<T>,
}

impl<T: Float> FeedForward<T> {
    pub fn new(mlp: &Mlp, [speeds, accelerations, torques]: [&[f64]; 3]) -> Self {
        let inverse = |values: &[f64]| values.iter().map(|v| T::of(1.0 / v)).collect();
        Self {
            tape: MlpTape::new(mlp),
            per_speed: inverse(speeds),
            per_acceleration: inverse(accelerations),
            torque: torques.iter().map(|v| T::of(*v)).collect(),
            inputs: Vec::new(),
        }
    }
}

impl<T: Float> Term<T> for FeedForward<T> {
    fn prepare(&mut self, parameters: &[T]) {
        self.tape.prepare(parameters);
    }

    fn outputs(&mut self, parameters: &[T], block: &SampleBlock<T>, out: &mut [T]) {
        let columns = [(&block.v[..], &self.per_speed[..]), (&block.a[..], &self.per_acceleration[..])];
        join(&block.features, block.n_features(), &columns, &mut self.inputs);
        let found = self.tape.forward(parameters, &self.inputs);
        for (out, (y, scale)) in out.iter_mut().zip(found.iter().zip(self.torque.iter().cycle())) {
            *out = *y * *scale;
        }
    }

    fn derivatives(&mut self, parameters: &[T], _: &SampleBlock<T>, w: &[T], into: ByParameters<'_, T>) {
        self.inputs.clear();
        self.inputs.extend(w.iter().zip(self.torque.iter().cycle()).map(|(w, scale)| *w * *scale));
        self.tape.reverse_parameters(parameters, &self.inputs, into);
    }
}
