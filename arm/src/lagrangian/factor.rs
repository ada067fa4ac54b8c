//! A positive definite matrix from a network: a factor of it that is a Cholesky factor with positive diagonal and, beside it, dense
//! columns, with tangents and reverse pass.

use hysteron_learn::{Activation, ByParameters, Mlp, MlpTape, Real};

/// ln(e − 1): the softplus of it is 1.
const SHIFT: f64 = 0.541_324_854_612_918_1;
/// Numbers that go through registers side by side: rows of L have a multiple of them.
pub(super) const WIDE: usize = 8;

/// L(q) = [T | R], n rows: T lower triangular, T_ij = d_i o_ij below the diagonal and d_i softplus(o_ii + shift) on it, from outputs o of a
/// network, and any number of columns R_ik = d_i o_ik. The network gives them row by row, each with its part of T and then that of R; L
/// itself is a matrix with zeros above the diagonal and behind R, [i][`width`].
///
/// Every column of R is one more square in the kinetic energy ½ |Lᵀ q̇|². That of a rigid body is a sum of such squares, of the components of
/// its bodies' velocities, whose entries are sums of products of sines and cosines; those of its Cholesky factor are not.
#[derive(Debug)]
pub(crate) struct Factor<T> {
    n: usize,
    squares: usize,
    width: usize,
    tape: MlpTape<T>,
    /// Of every output of the network: d_i [√(kg m²)], and where it stands in L.
    scale: Vec<T>,
    places: Vec<usize>,
    /// [stream][row][i][`width`]: L, and its derivatives along up to two directions.
    streams: [Vec<T>; 3],
    n_streams: usize,
    /// [row][i] on the diagonal: o_ii + shift, its softplus, and the softplus's first and second derivative.
    diagonal: [Vec<T>; 4],
    cotangents: Vec<T>,
}

/// Outputs of the network of a factor with so many dense columns.
pub(crate) fn packed(n: usize, squares: usize) -> usize {
    n * (n + 1) / 2 + n * squares
}

/// The output that is element i of the diagonal.
fn on_diagonal(i: usize, squares: usize) -> usize {
    packed(i, squares) + i
}

impl<T: Real> Factor<T> {
    /// `scale` holds d_i of every joint; the outputs of the network are the elements.
    pub fn new(mlp: &Mlp, scale: &[f64]) -> Self {
        let n = scale.len();
        let squares = (mlp.outputs - packed(n, 0)) / n;
        let width = (n + squares).next_multiple_of(WIDE);
        let places = (0..n).flat_map(|i| (0..=i).chain(n..n + squares).map(move |k| i * width + k)).collect();
        let scale = (0..n).flat_map(|i| vec![T::of(scale[i]); i + 1 + squares]).collect();
        let (tape, streams) = (MlpTape::new(mlp), std::array::from_fn(|_| Vec::new()));
        let (diagonal, cotangents) = (std::array::from_fn(|_| Vec::new()), Vec::new());
        Self { n, squares, width, tape, scale, places, streams, n_streams: 0, diagonal, cotangents }
    }

    /// Numbers of a row of L.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Numbers of L.
    pub fn len(&self) -> usize {
        self.n * self.width
    }

    /// L of one row of the batch and stream.
    pub fn row(&self, stream: usize, row: usize) -> &[T] {
        &self.streams[stream][row * self.len()..][..self.len()]
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

    fn take_values(&mut self) {
        let (n, squares, width) = (self.n, self.squares, self.width);
        let [x, y, d, dd] = &mut self.diagonal;
        x.clear();
        for raw in self.tape.outputs(0).chunks_exact(self.scale.len()) {
            x.extend((0..n).map(|i| raw[on_diagonal(i, squares)] + T::of(SHIFT)));
        }
        for values in [&mut *y, &mut *d, &mut *dd] {
            values.resize(x.len(), T::default());
        }
        Activation::Softplus.apply(x, y, d, dd);
        self.scatter(0);
        let rows = self.streams[0].chunks_exact_mut(n * width).zip(self.diagonal[1].chunks_exact(n));
        for (l, softplus) in rows {
            for (i, y) in softplus.iter().enumerate() {
                l[i * width + i] = self.scale[on_diagonal(i, squares)] * *y;
            }
        }
        self.n_streams = 1;
    }

    fn take_tangent(&mut self, stream: usize) {
        self.scatter(stream);
        let (n, width) = (self.n, self.width);
        let rows = self.streams[stream].chunks_exact_mut(n * width).zip(self.diagonal[2].chunks_exact(n));
        for (l, slopes) in rows {
            for (i, slope) in slopes.iter().enumerate() {
                l[i * width + i] *= *slope;
            }
        }
        self.n_streams = stream + 1;
    }

    /// Writes d_i o of every output to its place. What is no output's place stays zero.
    fn scatter(&mut self, stream: usize) {
        let (m, len) = (self.scale.len(), self.len());
        let outputs = self.tape.outputs(stream);
        let matrices = &mut self.streams[stream];
        matrices.resize(outputs.len() / m * len, T::default());
        for (raw, l) in outputs.chunks_exact(m).zip(matrices.chunks_exact_mut(len)) {
            for ((o, d), place) in raw.iter().zip(&self.scale).zip(&self.places) {
                l[*place] = *d * *o;
            }
        }
    }

    /// Appends the derivatives by the outputs, from those by L ([row][i][`width`]), without those of the softplus's slope by values.
    fn gather(&mut self, by_l: &[T]) {
        let (n, m, len) = (self.n, self.scale.len(), self.len());
        for (by_l, slopes) in by_l.chunks_exact(len).zip(self.diagonal[2].chunks_exact(n)) {
            let begin = self.cotangents.len();
            self.cotangents.extend(self.places.iter().zip(&self.scale).map(|(place, d)| *d * by_l[*place]));
            let row = &mut self.cotangents[begin..begin + m];
            for (i, slope) in slopes.iter().enumerate() {
                row[on_diagonal(i, self.squares)] *= *slope;
            }
        }
    }

    /// Forgets all streams but the first `n`.
    pub fn keep(&mut self, n: usize) {
        self.tape.keep(n);
        self.n_streams = n;
    }

    /// Derivatives by the features, from those by L (stream 0).
    pub fn reverse_features(&mut self, parameters: &[T], by_l: &[T]) -> &[T] {
        self.cotangents.clear();
        self.gather(by_l);
        self.tape.reverse_inputs(parameters, &self.cotangents)
    }

    /// Adds derivatives by the parameters, from those by every stream of L but the last, `by_l` ([stream], each [row][i][`width`]), and by
    /// the last: those that [`Self::reverse_features`] was given for the values, whose way back is not gone again.
    pub fn reverse_parameters<const N: usize>(
        &mut self,
        parameters: &[T],
        by_l: [&[T]; N],
        by_last: &[T],
        into: ByParameters<'_, T>,
    ) {
        let (n, m, len) = (self.n, self.scale.len(), self.len());
        self.cotangents.clear();
        for by_l in by_l {
            self.gather(by_l);
        }
        for (s, by_l) in by_l.into_iter().chain([by_last]).enumerate().skip(1) {
            let raw = self.tape.outputs(s);
            for (row, curvatures) in self.diagonal[3].chunks_exact(n).enumerate() {
                for (i, curvature) in curvatures.iter().enumerate() {
                    let k = on_diagonal(i, self.squares);
                    let by_diagonal = self.scale[k] * by_l[row * len + i * self.width + i];
                    self.cotangents[row * m + k] += *curvature * raw[row * m + k] * by_diagonal;
                }
            }
        }
        self.tape.reverse_parameters_repeating(parameters, &self.cotangents, into);
    }
}

/// out = Lᵀ v.
#[inline]
pub(crate) fn transposed_times<T: Real>(l: &[T], v: &[T], out: &mut [T]) {
    let (l, out) = (l.as_chunks::<WIDE>().0, out.as_chunks_mut::<WIDE>().0);
    let n_chunks = out.len();
    for (c, out) in out.iter_mut().enumerate() {
        let mut sums = [T::default(); WIDE];
        for (l, v) in l[c..].iter().step_by(n_chunks).zip(v) {
            for k in 0..WIDE {
                sums[k] += l[k] * *v;
            }
        }
        *out = sums;
    }
}

/// out += L u.
#[inline]
pub(crate) fn add_times<T: Real>(l: &[T], u: &[T], out: &mut [T]) {
    let (l, u) = (l.as_chunks::<WIDE>().0, u.as_chunks::<WIDE>().0);
    for (l, out) in l.chunks_exact(u.len()).zip(out) {
        let mut sums = [T::default(); WIDE];
        for (l, u) in l.iter().zip(u) {
            for k in 0..WIDE {
                sums[k] += l[k] * u[k];
            }
        }
        let [a, b, c, d]: [T; WIDE / 2] = std::array::from_fn(|k| sums[k] + sums[k + WIDE / 2]);
        *out += (a + c) + (b + d);
    }
}

/// The derivatives by L of Σ wᵀ L u: Σ w uᵀ, where L is always zero too.
#[inline]
pub(crate) fn outer_products<T: Real, const N: usize>(by_l: &mut [T], pairs: [(&[T], &[T]); N]) {
    let width = pairs[0].1.len();
    for (i, by_l) in by_l.chunks_exact_mut(width).enumerate() {
        for (c, by_l) in by_l.as_chunks_mut::<WIDE>().0.iter_mut().enumerate() {
            let mut sums = [T::default(); WIDE];
            for (w, u) in pairs {
                let u = &u.as_chunks::<WIDE>().0[c];
                for k in 0..WIDE {
                    sums[k] += w[i] * u[k];
                }
            }
            *by_l = sums;
        }
    }
}
