//! A positive definite matrix from a network: a factor of it that is a Cholesky factor with positive diagonal
//! and, next to it, dense columns, with tangents and reverse pass.

use hysteron_learn::{Activation, ByParameters, Float, Mlp, MlpTape};

use super::side::{FactorForm, SIDE, Side, of_row};

/// ln(e − 1): the softplus of it is 1.
const SHIFT: f64 = 0.541_324_854_612_918_1;

/// L(q) = [T | R], n rows: T lower triangular, T_ij = d_i o_ij below the diagonal and d_i softplus(o_ii + shift) on it, from outputs o of a
/// network, and any number of columns R_ik = d_i o_ik. The network gives them row by row, each with its part of T and then that of R; L
/// has the same order, and rows of the batch side by side.
///
/// Every column of R is one more square in the kinetic energy ½ |Lᵀ q̇|². That of a rigid body is a sum of such squares, of the components of
/// its bodies' velocities, whose entries are sums of products of sines and cosines; those of its Cholesky factor are not.
#[derive(Debug)]
pub(crate) struct Factor<T> {
    form: FactorForm,
    tape: MlpTape<T>,
    /// d_i of every output of the network [√(kg m²)].
    scale: Vec<T>,
    /// [stream][group of rows][element]: L, and its derivatives along up to two directions.
    streams: [Vec<Side<T>>; 3],
    n_streams: usize,
    /// [row][i] on the diagonal: o_ii + shift, its softplus, and the softplus's first and second derivative.
    diagonal: [Vec<T>; 4],
    cotangents: Vec<T>,
}

/// Outputs of the network of a factor with so many dense columns.
pub(crate) fn packed(n: usize, squares: usize) -> usize {
    FactorForm { n, squares }.len()
}

impl<T: Float> Factor<T> {
    /// `scale` holds d_i of every joint; the outputs of the network are the elements.
    pub fn new(mlp: &Mlp, scale: &[f64]) -> Self {
        let n = scale.len();
        let squares = (mlp.outputs - packed(n, 0)) / n;
        let scale = (0..n).flat_map(|i| vec![T::of(scale[i]); i + 1 + squares]).collect();
        let (tape, streams) = (MlpTape::new(mlp), std::array::from_fn(|_| Vec::new()));
        let (diagonal, cotangents) = (std::array::from_fn(|_| Vec::new()), Vec::new());
        Self { form: FactorForm { n, squares }, tape, scale, streams, n_streams: 0, diagonal, cotangents }
    }

    /// Which elements L has.
    pub fn form(&self) -> FactorForm {
        self.form
    }

    /// L, or its derivative along a direction: [group of rows][element].
    pub fn stream(&self, stream: usize) -> &[Side<T>] {
        &self.streams[stream]
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
        let FactorForm { n, .. } = self.form;
        let [x, y, d, dd] = &mut self.diagonal;
        x.clear();
        for raw in self.tape.outputs(0).chunks_exact(self.scale.len()) {
            x.extend((0..n).map(|i| raw[self.form.on_diagonal(i)] + T::of(SHIFT)));
        }
        for values in [&mut *y, &mut *d, &mut *dd] {
            values.resize(x.len(), T::default());
        }
        Activation::Softplus.apply(x, y, d, dd);
        self.take(0, |l, softplus, scale| *l = scale * softplus);
    }

    fn take_tangent(&mut self, stream: usize) {
        self.take(stream, |l, slope, _| *l *= slope);
    }

    /// Writes d_i o of every output as an element of this stream; `turn` then transforms the diagonal elements, the
    /// softplus (stream 0) or its slope, and d_i.
    fn take(&mut self, stream: usize, turn: impl Fn(&mut T, T, T)) {
        let (form, m) = (self.form, self.scale.len());
        let elements = &mut self.streams[stream];
        let outputs = self.tape.outputs(stream);
        elements.resize((outputs.len() / m).div_ceil(SIDE) * m, [T::default(); SIDE]);
        let on_diagonal = self.diagonal[if stream == 0 { 1 } else { 2 }].chunks(SIDE * form.n);
        let groups = outputs.chunks(SIDE * m).zip(on_diagonal).zip(elements.chunks_exact_mut(m));
        for ((raw, on_diagonal), l) in groups {
            for (r, (raw, on_diagonal)) in
                raw.chunks_exact(m).zip(on_diagonal.chunks_exact(form.n)).enumerate()
            {
                for ((l, o), d) in l.iter_mut().zip(raw).zip(&self.scale) {
                    l[r] = *d * *o;
                }
                for (i, value) in on_diagonal.iter().enumerate() {
                    let k = form.on_diagonal(i);
                    turn(&mut l[k][r], *value, self.scale[k]);
                }
            }
        }
        self.n_streams = stream + 1;
    }

    /// Appends the derivatives by the outputs, from those by L, without those of the softplus's slope by values.
    fn gather(&mut self, by_l: &[Side<T>]) {
        let (form, m) = (self.form, self.scale.len());
        for (row, slopes) in self.diagonal[2].chunks_exact(form.n).enumerate() {
            let (by_l, r) = (&by_l[row / SIDE * m..][..m], row % SIDE);
            let begin = self.cotangents.len();
            self.cotangents.extend(by_l.iter().zip(&self.scale).map(|(by_l, d)| *d * by_l[r]));
            let row = &mut self.cotangents[begin..];
            for (i, slope) in slopes.iter().enumerate() {
                row[form.on_diagonal(i)] *= *slope;
            }
        }
    }

    /// Forgets all streams but the first `n`.
    pub fn keep(&mut self, n: usize) {
        self.tape.keep(n);
        self.n_streams = n;
    }

    /// Derivatives by the features, from those by L (stream 0).
    pub fn reverse_features(&mut self, parameters: &[T], by_l: &[Side<T>]) -> &[T] {
        self.cotangents.clear();
        self.gather(by_l);
        self.tape.reverse_inputs(parameters, &self.cotangents)
    }

    /// Adds derivatives by the parameters, from those by every stream of L but the last, `by_l`, and by the last: those that
    /// [`Self::reverse_features`] was given for the values, whose way back is not gone again.
    pub fn reverse_parameters<const N: usize>(
        &mut self,
        parameters: &[T],
        by_l: [&[Side<T>]; N],
        by_last: &[Side<T>],
        into: ByParameters<'_, T>,
    ) {
        let (form, m) = (self.form, self.scale.len());
        self.cotangents.clear();
        for by_l in by_l {
            self.gather(by_l);
        }
        for (s, by_l) in by_l.into_iter().chain([by_last]).enumerate().skip(1) {
            let raw = self.tape.outputs(s);
            for (row, curvatures) in self.diagonal[3].chunks_exact(form.n).enumerate() {
                for (i, curvature) in curvatures.iter().enumerate() {
                    let k = form.on_diagonal(i);
                    let by_diagonal = self.scale[k] * of_row(by_l, m, row, k);
                    self.cotangents[row * m + k] += *curvature * raw[row * m + k] * by_diagonal;
                }
            }
        }
        self.tape.reverse_parameters_repeating(parameters, &self.cotangents, into);
    }
}
