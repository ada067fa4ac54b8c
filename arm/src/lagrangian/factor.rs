//! A positive definite matrix from a network: a factor of it that is a Cholesky factor with positive diagonal and, beside it, dense
//! columns, with tangents and reverse pass.

use hysteron_learn::{Activation, ByParameters, Mlp, MlpTape, Real};

/// ln(e − 1): the softplus of it is 1.
const SHIFT: f64 = 0.541_324_854_612_918_1;

/// L(q) = [T | R], n rows: T lower triangular, T_ij = d_i o_ij below the diagonal and d_i softplus(o_ii + shift) on it, from outputs o of a
/// network, and any number of columns R_ik = d_i o_ik. Packed row by row, each with its part of T and then that of R.
///
/// Every column of R is one more square in the kinetic energy ½ |Lᵀ q̇|². That of a rigid body is a sum of such squares, of the components of
/// its bodies' velocities, whose entries are sums of products of sines and cosines; those of its Cholesky factor are not.
#[derive(Debug)]
pub(crate) struct Factor<T> {
    n: usize,
    squares: usize,
    tape: MlpTape<T>,
    /// d_i for every packed element [√(kg m²)].
    scale: Vec<T>,
    /// [stream][row][element]: L, and its derivatives along up to two directions.
    streams: [Vec<T>; 3],
    n_streams: usize,
    /// [row][element]: first and second derivatives of L by o.
    slope: Vec<T>,
    curvature: Vec<T>,
    cotangents: Vec<T>,
}

/// Elements of a packed factor with so many dense columns.
pub(crate) fn packed(n: usize, squares: usize) -> usize {
    n * (n + 1) / 2 + n * squares
}

impl<T: Real> Factor<T> {
    /// `scale` holds d_i of every joint; the outputs of the network are the elements.
    pub fn new(mlp: &Mlp, scale: &[f64]) -> Self {
        let n = scale.len();
        let squares = (mlp.outputs - packed(n, 0)) / n;
        let scale = (0..n).flat_map(|i| vec![T::of(scale[i]); i + 1 + squares]).collect();
        let [slope, curvature, cotangents] = std::array::from_fn(|_| Vec::new());
        let (tape, streams) = (MlpTape::new(mlp), std::array::from_fn(|_| Vec::new()));
        Self { n, squares, tape, scale, streams, n_streams: 0, slope, curvature, cotangents }
    }

    /// Elements of L.
    pub fn len(&self) -> usize {
        self.scale.len()
    }

    /// Columns of L.
    pub fn columns(&self) -> usize {
        self.n + self.squares
    }

    /// L of one row and stream.
    pub fn row(&self, stream: usize, row: usize) -> &[T] {
        let m = self.len();
        &self.streams[stream][row * m..(row + 1) * m]
    }

    /// See [`MlpTape::prepare`].
    pub fn prepare(&mut self, parameters: &[T]) {
        self.tape.prepare(parameters);
    }

    /// L for these features; begins a new pass.
    pub fn forward(&mut self, parameters: &[T], features: &[T]) {
        self.tape.forward(parameters, features);
        self.take_values();
    }

    /// The same, and as stream 1 the derivative of L along features that move like `tangents`.
    pub fn forward_along(&mut self, parameters: &[T], features: &[T], tangents: &[T]) {
        self.tape.forward_along(parameters, features, tangents);
        self.take_values();
        self.take_tangent(1);
    }

    /// One more stream: the derivative of L along features that move like `tangents`.
    pub fn push(&mut self, parameters: &[T], tangents: &[T]) {
        self.tape.push_tangent(parameters, tangents);
        self.take_tangent(self.n_streams);
    }

    /// L and its derivatives by the outputs of the network.
    fn take_values(&mut self) {
        let (n, m) = (self.n, self.len());
        self.n_streams = 1;
        let value = &mut self.streams[0];
        for values in [&mut *value, &mut self.slope, &mut self.curvature] {
            values.clear();
        }
        for raw in self.tape.outputs(0).chunks_exact(m) {
            value.extend(raw.iter().zip(&self.scale).map(|(o, d)| *d * *o));
            self.slope.extend_from_slice(&self.scale);
            self.curvature.resize(value.len(), T::default());
            for i in 0..n {
                let k = packed(i, self.squares) + i;
                let d = self.scale[k];
                let [y, first, second] = Activation::Softplus.at(raw[k] + T::of(SHIFT));
                let at = value.len() - m + k;
                (value[at], self.slope[at], self.curvature[at]) = (d * y, d * first, d * second);
            }
        }
    }

    fn take_tangent(&mut self, stream: usize) {
        let tangent = &mut self.streams[stream];
        tangent.clear();
        tangent.extend(self.tape.outputs(stream).iter().zip(&self.slope).map(|(o, slope)| *slope * *o));
        self.n_streams = stream + 1;
    }

    /// Forgets all streams but the first `n`.
    pub fn keep(&mut self, n: usize) {
        self.tape.keep(n);
        self.n_streams = n;
    }

    /// Derivatives by the features, from those by L (stream 0).
    pub fn reverse_features(&mut self, parameters: &[T], by_l: &[T]) -> &[T] {
        self.cotangents.clear();
        self.cotangents.extend(by_l.iter().zip(&self.slope).map(|(g, slope)| *g * *slope));
        self.tape.reverse_inputs(parameters, &self.cotangents)
    }

    /// Adds derivatives by the parameters, from those by every stream of L ([stream][row][element]).
    pub fn reverse_parameters(&mut self, parameters: &[T], by_l: &[T], into: ByParameters<'_, T>) {
        let len = self.slope.len();
        self.cotangents.clear();
        for by_l in by_l.chunks_exact(len) {
            self.cotangents.extend(by_l.iter().zip(&self.slope).map(|(g, slope)| *g * *slope));
        }
        let (value, _) = self.cotangents.split_at_mut(len);
        for (s, by_l) in by_l.chunks_exact(len).enumerate().skip(1) {
            let raw = self.tape.outputs(s);
            for i in 0..len {
                value[i] += self.curvature[i] * raw[i] * by_l[i];
            }
        }
        self.tape.reverse_parameters(parameters, &self.cotangents, into);
    }
}

/// out = Lᵀ v.
#[inline]
pub(crate) fn transposed_times<T: Real>(l: &[T], v: &[T], out: &mut [T]) {
    out.fill(T::default());
    let (triangle, dense) = out.split_at_mut(v.len());
    let mut k = 0;
    for (i, v) in v.iter().enumerate() {
        for out in triangle[..=i].iter_mut().chain(&mut *dense) {
            *out += l[k] * *v;
            k += 1;
        }
    }
}

/// out += L u.
#[inline]
pub(crate) fn add_times<T: Real>(l: &[T], u: &[T], out: &mut [T]) {
    let (triangle, dense) = u.split_at(out.len());
    let mut k = 0;
    for (i, out) in out.iter_mut().enumerate() {
        for u in triangle[..=i].iter().chain(dense) {
            *out += l[k] * *u;
            k += 1;
        }
    }
}

/// The derivatives by L of wᵀ L u, times `factor`, added to `by_l`: factor · w uᵀ, where L is not always zero.
#[inline]
pub(crate) fn add_outer<T: Real>(by_l: &mut [T], factor: T, w: &[T], u: &[T]) {
    let (triangle, dense) = u.split_at(w.len());
    let mut k = 0;
    for (i, w) in w.iter().enumerate() {
        for u in triangle[..=i].iter().chain(dense) {
            by_l[k] += factor * *w * *u;
            k += 1;
        }
    }
}
