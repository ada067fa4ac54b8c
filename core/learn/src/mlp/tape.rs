//! One pass of a multi-layer perceptron over a batch, with directional derivatives, and its reverse pass.
//!
//! A pass carries streams: the values, any number of tangents (directional derivatives by the inputs), and mixed second
//! derivatives along two of them. Every stream is a matrix [row of the batch][unit], so that a layer is one product of
//! matrices for each stream. The reverse pass is ordinary first-order back-propagation through all of them:
//!
//! ```text
//! y = f(x), y_a = f' x_a, y_ab = f'' x_a x_b + f' x_ab
//! x̄ = f' ȳ + f'' Σ_a x_a ȳ_a + (f''' x_a x_b + f'' x_ab) ȳ_ab,  x̄_a = f' ȳ_a + f'' x_b ȳ_ab,  x̄_ab = f' ȳ_ab
//! ```
//!
//! Derivatives of a torque that is itself a derivative of an energy need no Jacobians so: see the crate `arm`.
//!
//! The derivative of a number along a direction has, on every layer of that tangent, the cotangents that the number's gradient has of
//! the values: where the gradient has just found them, they are not computed again ([`MlpTape::reverse_parameters_repeating`]).

use hysteron_base::lanes::{Isa, Simd, WithSimd};

use super::activation::Activation;
use super::derivatives::ByParameters;
use super::shape::{LayerShape, Mlp};
use super::small_batch::{FEW, times, times_transposed, transposed};
use crate::Float;
use crate::product::{multiply, multiply_add, rows};

/// Streams, values and derivatives of a pass; reused from batch to batch.
#[derive(Debug, Clone)]
pub struct MlpTape<T> {
    mlp: Mlp,
    shapes: Vec<LayerShape>,
    n_rows: usize,
    streams: Vec<DerivativeStream>,
    layers: Vec<TapeLayer<T>>,
    /// Weights of every layer, then S, as [input][output]; empty unless passes have been prepared.
    transposed: Vec<Vec<T>>,
    /// Cotangents of the layer at hand, and of the one before it: [stream][row][unit].
    cotangents: [Vec<T>; 2],
    /// Cotangents of the outputs in the last `reverse_inputs` of values alone, [row][output]; empty where there was none.
    seeds: Vec<T>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum DerivativeStream {
    Value,
    Tangent,
    /// Along these two tangents.
    Mixed(usize, usize),
}

/// Streams of a reverse pass.
#[derive(Debug, Clone, Copy)]
struct BackwardStreams {
    /// 1 where the values have no cotangents on any layer, else 0.
    first: usize,
    /// Streams whose cotangents are given; there is one more where the last one's are those of the gradient before.
    n_given: usize,
    n_streams: usize,
    repeats: bool,
    /// Whether cotangents on every layer are kept for a pass that repeats them.
    keeps_inputs: bool,
}

/// Every array is [stream][row][unit], `d` and `dd` are [row][unit]; after the streams in use there may be those of a larger pass.
#[derive(Debug, Clone, Default)]
struct TapeLayer<T> {
    /// Inputs of the layer.
    input: Vec<T>,
    /// W x, in the last layer W x + b, and its tangents.
    sum: Vec<T>,
    /// f' and f'' at W x + b; empty in the last layer.
    d: Vec<T>,
    dd: Vec<T>,
    /// Cotangents of the inputs, in the last `reverse_inputs` of values alone: [row][unit].
    by_input: Vec<T>,
}

/// The first `len` numbers of scratch that only grows: what is written next need not be cleared.
fn room<T: Clone + Default>(scratch: &mut Vec<T>, len: usize) -> &mut [T] {
    if scratch.len() < len {
        scratch.resize(len, T::default());
    }
    &mut scratch[..len]
}

/// The part of an array that belongs to one stream.
fn part<T>(values: &[T], stream: usize, len: usize) -> &[T] {
    &values[stream * len..(stream + 1) * len]
}

impl<T: Float> MlpTape<T> {
    /// Scratch for networks of this shape.
    pub fn new(mlp: &Mlp) -> Self {
        let shapes = mlp.layers();
        let layer = |_| {
            let [input, sum, d, dd, by_input] = std::array::from_fn(|_| Vec::new());
            TapeLayer { input, sum, d, dd, by_input }
        };
        let layers = shapes.iter().map(layer).collect();
        Self {
            mlp: mlp.clone(),
            shapes,
            n_rows: 0,
            streams: Vec::new(),
            layers,
            transposed: Vec::new(),
            cotangents: [Vec::new(), Vec::new()],
            seeds: Vec::new(),
        }
    }

    /// From now on all passes are with these parameters: their weights are transposed here once, which makes passes over a few rows
    /// faster.
    pub fn prepare(&mut self, parameters: &[T]) {
        let layer = |shape: &LayerShape| transposed(shape.split(parameters).0, shape.inputs);
        self.transposed = self.shapes.iter().map(layer).collect();
        self.transposed.push(transposed(self.past(parameters), self.mlp.inputs));
    }

    /// S, or nothing.
    fn past<'a>(&self, parameters: &'a [T]) -> &'a [T] {
        let len = if self.mlp.skip { self.mlp.inputs * self.mlp.outputs } else { 0 };
        if len == 0 { &[] } else { &parameters[self.mlp.skip_start()..][..len] }
    }

    /// The values for `inputs` ([row][input]); begins a new pass.
    pub fn forward(&mut self, parameters: &[T], inputs: &[T]) -> &[T] {
        self.begin(inputs);
        self.push(parameters, &[DerivativeStream::Value])
    }

    /// The same with the derivatives along `tangents` ([row][input]) as stream 1: both at once, which reads the weights once.
    pub fn forward_along(&mut self, parameters: &[T], inputs: &[T], tangents: &[T]) {
        self.begin(inputs);
        self.enter(1, tangents);
        self.push(parameters, &[DerivativeStream::Value, DerivativeStream::Tangent]);
    }

    /// One more stream: the derivatives of the outputs along `tangents` ([row][input]). Streams count from 1 in the order
    /// of these calls; stream 0 holds the values.
    pub fn push_tangent(&mut self, parameters: &[T], tangents: &[T]) -> &[T] {
        self.enter(self.streams.len(), tangents);
        self.push(parameters, &[DerivativeStream::Tangent])
    }

    /// One more stream: the second derivatives along the tangents of streams `a` and `b`, which must not be the same.
    pub fn push_mixed(&mut self, parameters: &[T], a: usize, b: usize) -> &[T] {
        assert!(
            a != b && [a, b].iter().all(|s| self.streams.get(*s) == Some(&DerivativeStream::Tangent)),
            "streams {a}, {b}"
        );
        let zeros = vec![T::default(); self.n_rows * self.mlp.inputs];
        self.enter(self.streams.len(), &zeros);
        self.push(parameters, &[DerivativeStream::Mixed(a, b)])
    }

    /// The outputs of one stream: [row][output].
    pub fn outputs(&self, stream: usize) -> &[T] {
        let last = self.layers.len() - 1;
        part(&self.layers[last].sum, stream, self.n_rows * self.mlp.outputs)
    }

    fn begin(&mut self, inputs: &[T]) {
        self.n_rows = inputs.len() / self.mlp.inputs;
        self.streams.clear();
        self.seeds.clear();
        self.enter(0, inputs);
    }

    /// Writes the inputs of the first layer for this stream.
    fn enter(&mut self, stream: usize, inputs: &[T]) {
        assert_eq!(inputs.len(), self.n_rows * self.mlp.inputs, "inputs of {} rows", self.n_rows);
        let values = &mut self.layers[0].input;
        values.truncate(stream * inputs.len());
        values.extend_from_slice(inputs);
    }

    /// More streams, side by side, of what has entered; gives the outputs of the last.
    fn push(&mut self, parameters: &[T], more: &[DerivativeStream]) -> &[T] {
        let first = self.streams.len();
        self.streams.extend_from_slice(more);
        let (n_rows, n_streams) = (self.n_rows, self.streams.len());
        let last = self.layers.len() - 1;
        for l in 0..=last {
            let shape = &self.shapes[l];
            let (weights, biases) = shape.split(parameters);
            let len = n_rows * shape.outputs;
            let (here, after) = self.layers.split_at_mut(l + 1);
            let layer = &mut here[l];
            let out = &mut room(&mut layer.sum, n_streams * len)[first * len..];
            let x = &layer.input[first * n_rows * shape.inputs..][..more.len() * n_rows * shape.inputs];
            match self.transposed.get(l) {
                Some(transposed) if more.len() * n_rows <= FEW => {
                    times(out, x, transposed, shape.outputs, false)
                }
                None if more.len() * n_rows <= FEW => times_transposed(out, x, weights, shape.inputs),
                _ => multiply(out, rows(x, shape.inputs), rows(weights, shape.inputs).transpose()),
            }
            if l < last {
                let next = room(&mut after[0].input, n_streams * len);
                for (s, stream) in (first..).zip(more) {
                    let next = &mut next[s * len..(s + 1) * len];
                    layer.activate(self.mlp.activation, biases, s, *stream, len, next);
                }
            } else if more[0] == DerivativeStream::Value {
                for row in out[..len].chunks_exact_mut(shape.outputs) {
                    for (y, b) in row.iter_mut().zip(biases) {
                        *y += *b;
                    }
                }
            }
        }
        self.past_the_layers(parameters, first);
        self.outputs(n_streams - 1)
    }

    /// Adds S x to the outputs of the streams from `first` on.
    fn past_the_layers(&mut self, parameters: &[T], first: usize) {
        if !self.mlp.skip {
            return;
        }
        let (Mlp { inputs, outputs, .. }, last) = (&self.mlp, self.layers.len() - 1);
        let (inputs, outputs) = (*inputs, *outputs);
        let entered = std::mem::take(&mut self.layers[0].input);
        let x = &entered[first * self.n_rows * inputs..];
        let matrix = self.past(parameters);
        let len = self.n_rows * outputs;
        let out = &mut self.layers[last].sum[first * len..self.streams.len() * len];
        match self.transposed.last() {
            Some(transposed) if x.len() <= FEW * inputs => times(out, x, transposed, outputs, true),
            _ => multiply_add(out, rows(x, inputs), rows(matrix, inputs).transpose()),
        }
        self.layers[0].input = entered;
    }

    /// The derivatives of some number by the inputs of stream 0 ([row][input]), from those by the outputs of the first
    /// streams, `cotangents` ([stream][row][output]); the other streams do not count.
    pub fn reverse_inputs(&mut self, parameters: &[T], cotangents: &[T]) -> &[T] {
        self.reverse(parameters, cotangents, false, None);
        if self.mlp.skip {
            let (inputs, outputs) = (self.mlp.inputs, self.mlp.outputs);
            let matrix = self.past(parameters);
            let of_values = &cotangents[..self.n_rows * outputs];
            let by_inputs = &mut self.cotangents[0][..self.n_rows * inputs];
            if self.n_rows <= FEW {
                times(by_inputs, of_values, matrix, inputs, true);
            } else {
                multiply_add(by_inputs, rows(of_values, outputs), rows(matrix, inputs));
            }
        }
        part(&self.cotangents[0], 0, self.n_rows * self.mlp.inputs)
    }

    /// Adds the derivatives of some number by the parameters, from those by the outputs of the first streams,
    /// `cotangents` ([stream][row][output]); the other streams do not count.
    pub fn reverse_parameters(&mut self, parameters: &[T], cotangents: &[T], into: ByParameters<'_, T>) {
        self.reverse(parameters, cotangents, false, Some(into));
    }

    /// The same with one more stream, whose cotangents are those of the values in the last [`Self::reverse_inputs`] of this pass, which
    /// was of values alone: they are known on every layer.
    pub fn reverse_parameters_repeating(
        &mut self,
        parameters: &[T],
        cotangents: &[T],
        into: ByParameters<'_, T>,
    ) {
        assert_eq!(self.seeds.len(), self.n_rows * self.mlp.outputs, "no gradient of values to repeat");
        self.reverse(parameters, cotangents, true, Some(into));
    }

    /// Drops all streams but the first `n`.
    pub fn keep(&mut self, n: usize) {
        self.streams.truncate(n);
    }

    /// Which streams go back, from the cotangents given; `by_parameters`: whether derivatives by the parameters are asked for.
    fn way(&self, cotangents: &[T], repeats: bool, by_parameters: bool) -> BackwardStreams {
        let len = self.n_rows * self.mlp.outputs;
        let n_given = cotangents.len() / len;
        let n_streams = n_given + usize::from(repeats);
        assert!(
            n_given * len == cotangents.len() && n_streams <= self.streams.len(),
            "cotangents of streams"
        );
        assert!(!repeats || self.streams[n_given] == DerivativeStream::Tangent, "a tangent repeats");
        // Without f'' nothing comes from the tangents to values that have no cotangents of their own.
        let are_idle = by_parameters
            && !self.mlp.activation.is_curved()
            && cotangents[..len].iter().all(|c| *c == T::default());
        let keeps_inputs = !by_parameters && n_streams == 1;
        BackwardStreams { first: usize::from(are_idle), n_given, n_streams, repeats, keeps_inputs }
    }

    fn reverse(
        &mut self,
        parameters: &[T],
        cotangents: &[T],
        repeats: bool,
        mut into: Option<ByParameters<'_, T>>,
    ) {
        let way = self.way(cotangents, repeats, into.is_some());
        let BackwardStreams { first, n_streams, .. } = way;
        let Mlp { inputs, outputs, .. } = self.mlp;
        if way.keeps_inputs {
            self.seeds.clear();
            self.seeds.extend_from_slice(cotangents);
        }
        let here = room(&mut self.cotangents[0], n_streams * self.n_rows * outputs);
        here[..cotangents.len()].copy_from_slice(cotangents);
        here[cotangents.len()..].copy_from_slice(if repeats { &self.seeds } else { &[] });
        if let (true, Some(into)) = (self.mlp.skip, &mut into) {
            let shape = LayerShape { inputs, outputs, start: self.mlp.skip_start() };
            let entered = &self.layers[0].input[..n_streams * self.n_rows * inputs];
            into.add_weights(&shape, self.n_rows, here, entered);
        }
        for l in (0..self.layers.len()).rev() {
            if let Some(into) = &mut into {
                let shape = &self.shapes[l];
                let of = |units: usize| first * self.n_rows * units..n_streams * self.n_rows * units;
                let above = &self.cotangents[0][of(shape.outputs)];
                into.add_weights(shape, self.n_rows, above, &self.layers[l].input[of(shape.inputs)]);
                into.add_biases(shape, self.n_rows, if first == 0 { above } else { &[] });
                if l == 0 {
                    return;
                }
            }
            self.reverse_layer(parameters, l, way);
            self.cotangents.swap(0, 1);
        }
    }

    /// From the cotangents of the sums of layer `l` to those of the sums of the layer before, or of the inputs.
    fn reverse_layer(&mut self, parameters: &[T], l: usize, way: BackwardStreams) {
        let BackwardStreams { first, n_given, n_streams, repeats, keeps_inputs } = way;
        let shape = &self.shapes[l];
        let [len_above, len_below] = [shape.outputs, shape.inputs].map(|units| self.n_rows * units);
        let [here, before] = &mut self.cotangents;
        let above = &here[first * len_above..n_given * len_above];
        let below = &mut room(before, n_streams * len_below)[first * len_below..];
        let computed = match l {
            0 => &mut *below,
            _ if keeps_inputs => room(&mut self.layers[l].by_input, len_below),
            _ => &mut below[..(n_given - first) * len_below],
        };
        let weights = shape.split(parameters).0;
        if n_given * self.n_rows <= FEW {
            times(computed, above, weights, shape.inputs, false);
        } else if !computed.is_empty() {
            multiply(computed, rows(above, shape.outputs), rows(weights, shape.inputs));
        }
        if l > 0 {
            let (layers, after) = self.layers.split_at(l);
            let (layer, y, activation) = (&layers[l - 1], &after[0].input, self.mlp.activation);
            let last = (keeps_inputs || repeats).then(|| &after[0].by_input[..len_below]);
            let streams = &self.streams[..n_streams];
            Isa::detect().run(Through { layer, activation, streams, y, last, cotangents: below });
        }
    }
}

impl<T: Float> TapeLayer<T> {
    /// Writes the activations of stream `s` from its sums.
    fn activate(
        &mut self,
        activation: Activation,
        biases: &[T],
        s: usize,
        stream: DerivativeStream,
        len: usize,
        out: &mut [T],
    ) {
        if stream == DerivativeStream::Value {
            self.d.resize(len, T::default());
            self.dd.resize(len, T::default());
            activation.apply_to_sums(&self.sum[..len], biases, out, &mut self.d, &mut self.dd);
            return;
        }
        let first = match stream {
            DerivativeStream::Mixed(a, b) => Some([part(&self.sum, a, len), part(&self.sum, b, len)]),
            _ => None,
        };
        Isa::detect().run(Along { x: part(&self.sum, s, len), d: &self.d, dd: &self.dd, first, out });
    }
}

/// y_a = f' x_a, or y_ab = f'' x_a x_b + f' x_ab.
struct Along<'a, T> {
    x: &'a [T],
    d: &'a [T],
    dd: &'a [T],
    /// x_a and x_b.
    first: Option<[&'a [T]; 2]>,
    out: &'a mut [T],
}

impl<T: Float> WithSimd for Along<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let n = self.out.len();
        let (x, d, dd) = (&self.x[..n], &self.d[..n], &self.dd[..n]);
        match self.first {
            None => {
                for i in 0..n {
                    self.out[i] = d[i] * x[i];
                }
            }
            Some([a, b]) => {
                let (a, b) = (&a[..n], &b[..n]);
                for i in 0..n {
                    self.out[i] = dd[i] * a[i] * b[i] + d[i] * x[i];
                }
            }
        }
    }
}

/// The reverse pass through an activation; through one without f'' of any streams.
struct Through<'a, T> {
    layer: &'a TapeLayer<T>,
    activation: Activation,
    streams: &'a [DerivativeStream],
    /// Values after the activation come first in it.
    y: &'a [T],
    /// Incoming cotangents of the last stream; those of the others are at the place of their results.
    last: Option<&'a [T]>,
    cotangents: &'a mut [T],
}

impl<T: Float> WithSimd for Through<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let n = self.layer.d.len();
        let (d, dd, y) = (&self.layer.d[..n], &self.layer.dd[..n], &self.y[..n]);
        let sum = |s: usize| part(&self.layer.sum, s, n);
        let n_in_place = self.cotangents.len() / n - usize::from(self.last.is_some());
        let (in_place, of_last) = self.cotangents.split_at_mut(n_in_place * n);
        if self.activation.is_curved() && !in_place.is_empty() {
            let (value, others) = in_place.split_at_mut(n);
            for i in 0..n {
                value[i] *= d[i];
            }
            for (s, stream) in self.streams.iter().enumerate().skip(1) {
                let g = if s == n_in_place { self.last.unwrap_or_default() } else { part(others, s - 1, n) };
                let (g, x) = (&g[..n], sum(s));
                for i in 0..n {
                    value[i] += dd[i] * x[i] * g[i];
                }
                if let DerivativeStream::Mixed(a, b) = *stream {
                    let (a, b) = (sum(a), sum(b));
                    for i in 0..n {
                        value[i] += self.activation.third([y[i], d[i], dd[i]]) * a[i] * b[i] * g[i];
                    }
                }
            }
            for s in 1..n_in_place {
                let (tangents, rest) = others.split_at_mut((s - 1) * n);
                let own = &mut rest[..n];
                if let DerivativeStream::Mixed(a, b) = self.streams[s] {
                    let mixed = &own[..n];
                    for (along, other) in [(a, sum(b)), (b, sum(a))] {
                        let along = &mut tangents[(along - 1) * n..][..n];
                        for i in 0..n {
                            along[i] += dd[i] * other[i] * mixed[i];
                        }
                    }
                }
                for i in 0..n {
                    own[i] *= d[i];
                }
            }
        } else {
            for own in in_place.chunks_exact_mut(n) {
                for i in 0..n {
                    own[i] *= d[i];
                }
            }
        }
        if let Some(last) = self.last {
            let (own, last) = (&mut of_last[..n], &last[..n]);
            for i in 0..n {
                own[i] = d[i] * last[i];
            }
        }
    }
}
