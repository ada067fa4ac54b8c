//! A positive definite matrix from a network: its Cholesky factor with positive diagonal, with tangents and reverse pass.

use hysteron_learn::{Activation, ByParameters, Mlp, MlpTape, Real};

/// ln(e − 1): the softplus of it is 1.
const SHIFT: f64 = 0.541_324_854_612_918_1;

/// L(q), lower triangular: L_ij = d_i o_ij below the diagonal and d_i softplus(o_ii + shift) on it, from outputs o of a
/// network. Packed row by row: (0,0), (1,0), (1,1), (2,0), …
#[derive(Debug)]
pub(crate) struct Factor<T> {
    n: usize,
    tape: MlpTape<T>,
    /// d_i for every packed element [√(kg m²)].
    scale: Vec<T>,
    /// [stream][row][element]: L, and its derivatives along the directions that were pushed.
    streams: Vec<Vec<T>>,
    /// [row][element]: first and second derivatives of L by o.
    slope: Vec<T>,
    curvature: Vec<T>,
    cotangents: Vec<T>,
}

/// Elements of a packed triangle.
pub(crate) fn packed(n: usize) -> usize {
    n * (n + 1) / 2
}

impl<T: Real> Factor<T> {
    /// `scale` holds d_i of every joint.
    pub fn new(mlp: &Mlp, scale: &[f64]) -> Self {
        let n = scale.len();
        let scale = (0..n).flat_map(|i| vec![T::of(scale[i]); i + 1]).collect();
        let [slope, curvature, cotangents] = std::array::from_fn(|_| Vec::new());
        Self { n, tape: MlpTape::new(mlp), scale, streams: Vec::new(), slope, curvature, cotangents }
    }

    /// L of one row and stream.
    pub fn row(&self, stream: usize, row: usize) -> &[T] {
        let m = packed(self.n);
        &self.streams[stream][row * m..(row + 1) * m]
    }

    /// L for these features; begins a new pass.
    pub fn forward(&mut self, parameters: &[T], features: &[T]) {
        let (n, m) = (self.n, packed(self.n));
        let raw = self.tape.forward(parameters, features);
        self.streams.truncate(1);
        self.streams.resize(1, Vec::new());
        let value = &mut self.streams[0];
        for values in [&mut *value, &mut self.slope, &mut self.curvature] {
            values.clear();
        }
        for raw in raw.chunks_exact(m) {
            value.extend(raw.iter().zip(&self.scale).map(|(o, d)| *d * *o));
            self.slope.extend_from_slice(&self.scale);
            self.curvature.resize(value.len(), T::default());
            for i in 0..n {
                let k = packed(i + 1) - 1;
                let d = self.scale[k];
                let [y, first, second] = Activation::Softplus.at(raw[k] + T::of(SHIFT));
                let at = value.len() - m + k;
                (value[at], self.slope[at], self.curvature[at]) = (d * y, d * first, d * second);
            }
        }
    }

    /// One more stream: the derivative of L along features that move like `tangents`.
    pub fn push(&mut self, parameters: &[T], tangents: &[T]) {
        let raw = self.tape.push_tangent(parameters, tangents);
        self.streams.push(raw.iter().zip(&self.slope).map(|(o, slope)| *slope * *o).collect());
    }

    /// Forgets all streams but the first `n`.
    pub fn keep(&mut self, n: usize) {
        self.tape.keep(n);
        self.streams.truncate(n);
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
    let mut k = 0;
    for (i, v) in v.iter().enumerate() {
        for out in &mut out[..=i] {
            *out += l[k] * *v;
            k += 1;
        }
    }
}

/// out += L u.
#[inline]
pub(crate) fn add_times<T: Real>(l: &[T], u: &[T], out: &mut [T]) {
    let mut k = 0;
    for (i, out) in out.iter_mut().enumerate() {
        for u in &u[..=i] {
            *out += l[k] * *u;
            k += 1;
        }
    }
}

/// The derivatives by L of wᵀ L u, times `factor`, added to `by_l`: factor · w uᵀ, lower triangle.
#[inline]
pub(crate) fn add_outer<T: Real>(by_l: &mut [T], factor: T, w: &[T], u: &[T]) {
    let mut k = 0;
    for (i, w) in w.iter().enumerate() {
        for u in &u[..=i] {
            by_l[k] += factor * *w * *u;
            k += 1;
        }
    }
}
