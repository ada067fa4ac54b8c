//! `TransformerTape`: forward and backward passes over some sequences side by side, on plain arrays.

use std::ops::Range;

use hysteron_base::lanes::{Isa, Simd, WithSimd};

use super::kernels::{add_scaled, norm, norm_back, silu};
use super::layer::{Layer, LayerTape};
use super::linear::{Linear, linear_gradient};
use super::network::Transformer;
use super::shape::{TemporalForm, TransformerShape};
use crate::{Float, TrainableModel, product};

/// Values and gradients of passes through a network, for up to so many steps of some sequences side by side.
///
/// All arrays are time-major: [step][sequence][channel]. A window is a sequence of as many steps as the network has tokens, with
/// one output. In the streaming form steps may be handed over one by one or together: the result is the same to rounding.
#[derive(Debug, Clone)]
pub struct TransformerTape<T> {
    shape: TransformerShape,
    /// Steps there is room for; sequences side by side.
    size: (usize, usize),
    inputs: Vec<T>,
    /// Before the first layer, and after every one.
    tokens: Vec<Vec<T>>,
    layers: Vec<LayerTape<T>>,
    unit: Vec<T>,
    rate: Vec<T>,
    normed: Vec<T>,
    pooled: Vec<T>,
    latent: Vec<T>,
    slope: Vec<T>,
    outputs: Vec<T>,
    /// Gradients by tokens after the last normalisation, by those before the first layer, by latent numbers, outputs and inputs.
    d_normed: Vec<T>,
    d_embedded: Vec<T>,
    d_pooled: Vec<T>,
    d_latent: Vec<T>,
    d_outputs: Vec<T>,
    d_inputs: Vec<T>,
}

impl<T: Float> TransformerTape<T> {
    /// Room for `rows` sequences of up to `steps` steps.
    ///
    /// # Panics
    /// If windows are asked for that are not of the network's length.
    pub fn new(shape: &TransformerShape, steps: usize, rows: usize) -> Self {
        assert!(shape.form == TemporalForm::Streaming || steps == shape.tokens, "a window of {steps} tokens");
        let n = steps * rows;
        let zeros = |n: usize, width: usize| vec![T::default(); n * width];
        let (d, hidden) = (shape.width, shape.heads.len() * shape.latent);
        let results = match shape.form {
            TemporalForm::Window => rows,
            TemporalForm::Streaming => n,
        };
        Self {
            size: (steps, rows),
            inputs: zeros(n, shape.inputs),
            tokens: (0..=shape.layers).map(|_| zeros(n, d)).collect(),
            layers: (0..shape.layers).map(|_| LayerTape::new(shape, n)).collect(),
            unit: zeros(n, d),
            rate: zeros(n, 1),
            normed: zeros(n, d),
            pooled: zeros(results, d),
            latent: zeros(results, hidden),
            slope: zeros(results, hidden),
            outputs: zeros(results, shape.outputs()),
            d_normed: zeros(n, d),
            d_embedded: zeros(n, d),
            d_pooled: zeros(results, d),
            d_latent: zeros(results, hidden),
            d_outputs: zeros(results, shape.outputs()),
            d_inputs: zeros(n, shape.inputs),
            shape: shape.clone(),
        }
    }

    /// Whether the tape has as many sequences of such a network, and if so, its capacity in steps.
    pub(super) fn room(&self, shape: &TransformerShape, rows: usize) -> Option<usize> {
        (self.size.1 == rows && self.shape == *shape).then_some(self.size.0)
    }

    /// Sequences side by side.
    pub fn rows(&self) -> usize {
        self.size.1
    }

    /// Rows of outputs that belong to these steps.
    fn results(&self, steps: &Range<usize>) -> Range<usize> {
        match self.shape.form {
            TemporalForm::Window => 0..self.size.1,
            TemporalForm::Streaming => steps.start * self.size.1..steps.end * self.size.1,
        }
    }

    /// Steps whose mean is the input of the head for step `s`.
    fn pool(&self, s: usize) -> Range<usize> {
        match self.shape.form {
            TemporalForm::Window => 0..self.shape.tokens,
            TemporalForm::Streaming => (s + 1).saturating_sub(self.shape.pooled())..s + 1,
        }
    }

    /// Outputs of `steps` from their `inputs` (steps × rows × inputs); the forward pass has been through all
    /// steps before. A window takes all its steps at once and has one row of outputs for each sequence.
    ///
    /// # Panics
    /// If there is no room for these steps, or the inputs are not of their number.
    pub fn forward(&mut self, network: &Transformer<T>, steps: Range<usize>, inputs: &[T]) -> &[T] {
        let rows = self.size.1;
        assert!(steps.end <= self.size.0, "steps {steps:?} in {}", self.size.0);
        assert!(
            self.shape.form == TemporalForm::Streaming || steps == (0..self.shape.tokens),
            "a whole window"
        );
        self.inputs[steps.start * rows * self.shape.inputs..steps.end * rows * self.shape.inputs]
            .copy_from_slice(inputs);
        Isa::detect().run(TapeForward { tape: self, network, steps: &steps });
        let results = self.results(&steps);
        let n = self.shape.outputs();
        &self.outputs[results.start * n..results.end * n]
    }

    fn embed(&mut self, network: &Transformer<T>, steps: &Range<usize>) {
        let (rows, d, n) = (self.size.1, self.shape.width, self.shape.inputs);
        let parameters = &network.parameters()[0];
        let tokens = &mut self.tokens[0][steps.start * rows * d..steps.end * rows * d];
        let inputs = &self.inputs[steps.start * rows * n..steps.end * rows * n];
        input_of(network).forward(inputs, tokens);
        if let Some(positions) = &network.layout.positions {
            let positions = parameters[positions.clone()].chunks_exact(d);
            for (position, tokens) in positions.zip(tokens.chunks_exact_mut(rows * d)) {
                tokens.chunks_exact_mut(d).for_each(|token| add_scaled(token, T::of(1.0), position));
            }
        }
    }

    /// Last normalisation, mean over the window, heads.
    #[inline(always)]
    fn read_out(&mut self, network: &Transformer<T>, steps: &Range<usize>) {
        let (rows, d) = (self.size.1, self.shape.width);
        let parameters = network.parameters().last().map_or(&[][..], Vec::as_slice);
        let pair =
            |[weight, bias]: &[Range<usize>; 2]| [&parameters[weight.clone()], &parameters[bias.clone()]];
        let tokens = steps.start * rows * d..steps.end * rows * d;
        let top = &self.tokens[self.shape.layers][tokens.clone()];
        let normed = &mut self.normed[tokens.clone()];
        match &network.layout.norm {
            Some(own) => {
                let rate = &mut self.rate[steps.start * rows..steps.end * rows];
                norm(top, pair(own), &mut self.unit[tokens], rate, normed);
            }
            None => normed.copy_from_slice(top),
        }
        let results = self.results(steps);
        for row in results.clone() {
            let pool = self.pool(row / rows);
            let per = T::of(1.0 / pool.len() as f64);
            let pooled = &mut self.pooled[row * d..][..d];
            pooled.fill(T::default());
            for s in pool {
                add_scaled(pooled, per, &self.normed[(s * rows + row % rows) * d..][..d]);
            }
        }
        let hidden = self.shape.heads.len() * self.shape.latent;
        let part = |width: usize| results.start * width..results.end * width;
        let latent = &mut self.latent[part(hidden)];
        latent_of(network).forward(&self.pooled[part(d)], latent);
        for (h, slope) in latent.iter_mut().zip(&mut self.slope[part(hidden)]) {
            [*h, *slope] = silu(*h);
        }
        let n = self.shape.outputs();
        for row in results {
            let mut at = 0;
            for (k, head) in network.layout.heads.iter().enumerate() {
                let [weight, bias] = pair(head);
                let out = &mut self.outputs[row * n + at..][..bias.len()];
                out.copy_from_slice(bias);
                let latent = &self.latent[row * hidden + k * self.shape.latent..][..self.shape.latent];
                for (latent, weight) in latent.iter().zip(weight.chunks_exact(bias.len())) {
                    add_scaled(out, *latent, weight);
                }
                at += bias.len();
            }
        }
    }

    /// Clears the gradients before a backward pass from the last step.
    pub fn clear_gradients(&mut self) {
        self.d_normed.fill(T::default());
        self.layers.iter_mut().for_each(LayerTape::clear_gradients);
    }

    /// From the gradient by the outputs of `steps` to that by their inputs; the backward pass has been
    /// through all later steps since [`Self::clear_gradients`]. Adds to `gradient`, of the shape of the
    /// parameters, all but [`Self::weight_gradients`].
    ///
    /// # Panics
    /// If `d_outputs` is not as long as what [`Self::forward`] gave.
    pub fn backward(
        &mut self,
        network: &Transformer<T>,
        steps: Range<usize>,
        d_outputs: &[T],
        gradient: &mut [Vec<T>],
    ) -> &[T] {
        let (rows, d, n) = (self.size.1, self.shape.width, self.shape.inputs);
        let results = self.results(&steps);
        let outputs = self.shape.outputs();
        self.d_outputs[results.start * outputs..results.end * outputs].copy_from_slice(d_outputs);
        let tokens = steps.start * rows * d..steps.end * rows * d;
        Isa::detect().run(TapeBackward { tape: self, network, steps: &steps, gradient });
        let d_inputs = &mut self.d_inputs[steps.start * rows * n..steps.end * rows * n];
        input_of(network).back(&self.d_embedded[tokens], d_inputs);
        d_inputs
    }

    #[inline(always)]
    fn read_out_back(&mut self, network: &Transformer<T>, steps: &Range<usize>, gradient: &mut [Vec<T>]) {
        let (rows, d, latent) = (self.size.1, self.shape.width, self.shape.latent);
        let parameters = network.parameters().last().map_or(&[][..], Vec::as_slice);
        let (results, hidden) = (self.results(steps), self.shape.heads.len() * latent);
        let n = self.shape.outputs();
        for row in results.clone() {
            let mut at = 0;
            for (k, [weight, bias]) in network.layout.heads.iter().enumerate() {
                let d_out = &self.d_outputs[row * n + at..][..bias.len()];
                let weight = parameters[weight.clone()].chunks_exact(bias.len());
                for (j, weight) in weight.enumerate() {
                    let at = row * hidden + k * latent + j;
                    let by_latent: T = weight.iter().zip(d_out).map(|(w, d)| *w * *d).sum();
                    self.d_latent[at] = by_latent * self.slope[at];
                }
                at += bias.len();
            }
        }
        let part = |width: usize| results.start * width..results.end * width;
        latent_of(network).back(&self.d_latent[part(hidden)], &mut self.d_pooled[part(d)]);
        for row in results.clone() {
            let pool = self.pool(row / rows);
            let per = T::of(1.0 / pool.len() as f64);
            for s in pool {
                let token = &mut self.d_normed[(s * rows + row % rows) * d..][..d];
                add_scaled(token, per, &self.d_pooled[row * d..][..d]);
            }
        }
        let tokens = steps.start * rows * d..steps.end * rows * d;
        let dy = &mut self.d_embedded[tokens.clone()];
        match &network.layout.norm {
            Some([weight, bias]) => {
                dy.fill(T::default());
                let rate = &self.rate[steps.start * rows..steps.end * rows];
                let at = [&self.unit[tokens.clone()], rate, &self.d_normed[tokens]];
                let of_norm = gradient.last_mut().map_or(&mut [][..], |g| &mut g[weight.start..bias.end]);
                norm_back(at, &parameters[weight.clone()], dy, of_norm);
            }
            None => dy.copy_from_slice(&self.d_normed[tokens]),
        }
    }

    /// Adds the gradients by all matrices, of the first `steps` steps, after all backward passes.
    pub fn weight_gradients(&self, network: &Transformer<T>, steps: usize, gradient: &mut [Vec<T>]) {
        Isa::detect().run(WeightGradients { tape: self, network, steps, gradient });
    }

    #[inline(always)]
    fn add_weight_gradients(&self, network: &Transformer<T>, steps: usize, gradient: &mut [Vec<T>]) {
        let rows = self.size.1;
        let n = |width: usize| steps * rows * width;
        let (d, hidden) = (self.shape.width, self.shape.heads.len() * self.shape.latent);
        let layout = &network.layout;
        let embedded = &self.d_embedded[..n(d)];
        linear_gradient([&self.inputs[..n(self.shape.inputs)], embedded], &layout.input, &mut gradient[0]);
        if let Some(positions) = &layout.positions {
            let own = gradient[0][positions.clone()].chunks_exact_mut(d);
            for (position, tokens) in own.zip(embedded.chunks_exact(rows * d)) {
                tokens.chunks_exact(d).for_each(|token| add_scaled(position, T::of(1.0), token));
            }
        }
        for l in 0..self.shape.layers {
            Layer::of(network, l, rows).gradient(steps, &self.layers[l], &mut gradient[1 + l]);
        }
        let results = self.results(&(0..steps)).end;
        let head = &mut gradient[self.shape.layers + 1];
        let d_latent = &self.d_latent[..results * hidden];
        linear_gradient([&self.pooled[..results * d], d_latent], &layout.latent, head);
        let outputs = self.shape.outputs();
        let d_outputs = &self.d_outputs[..results * outputs];
        let mut at = 0;
        for (k, [weight, bias]) in layout.heads.iter().enumerate() {
            let latent = product::rows(&self.latent[..results * hidden], hidden);
            let latent = latent.subcols(k * self.shape.latent, self.shape.latent);
            let d_out = product::rows(d_outputs, outputs).subcols(at, bias.len());
            product::multiply_add(&mut head[weight.clone()], latent.transpose(), d_out);
            for d_outputs in d_outputs.chunks_exact(outputs) {
                add_scaled(&mut head[bias.clone()], T::of(1.0), &d_outputs[at..][..bias.len()]);
            }
            at += bias.len();
        }
    }
}

/// The first projection.
fn input_of<T: Float>(network: &Transformer<T>) -> Linear<'_, T> {
    Linear::of(&network.parameters()[0], &network.packed()[0], &network.layout.input)
}

/// That of the latent numbers, before the heads.
fn latent_of<T: Float>(network: &Transformer<T>) -> Linear<'_, T> {
    let last = network.shape().layers + 1;
    Linear::of(&network.parameters()[last], &network.packed()[last], &network.layout.latent)
}

/// A pass compiled for each instruction set, with all loops within it.
struct TapeForward<'a, T> {
    tape: &'a mut TransformerTape<T>,
    network: &'a Transformer<T>,
    steps: &'a Range<usize>,
}

impl<T: Float> WithSimd for TapeForward<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { tape, network, steps } = self;
        tape.embed(network, steps);
        for l in 0..tape.shape.layers {
            let (before, after) = tape.tokens.split_at_mut(l + 1);
            let layer = Layer::of(network, l, tape.size.1);
            layer.forward(steps.clone(), &before[l], &mut tape.layers[l], &mut after[0]);
        }
        tape.read_out(network, steps);
    }
}

/// As [`TapeForward`], backward.
struct TapeBackward<'a, T> {
    tape: &'a mut TransformerTape<T>,
    network: &'a Transformer<T>,
    steps: &'a Range<usize>,
    gradient: &'a mut [Vec<T>],
}

impl<T: Float> WithSimd for TapeBackward<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { tape, network, steps, gradient } = self;
        tape.read_out_back(network, steps, gradient);
        let width = tape.size.1 * tape.shape.width;
        let dy = &mut tape.d_embedded[steps.start * width..steps.end * width];
        for l in (0..tape.shape.layers).rev() {
            let layer = Layer::of(network, l, tape.size.1);
            layer.backward(steps.clone(), &mut tape.layers[l], dy, &mut gradient[1 + l]);
        }
    }
}

/// As [`TapeForward`], for the matrices.
struct WeightGradients<'a, T> {
    tape: &'a TransformerTape<T>,
    network: &'a Transformer<T>,
    steps: usize,
    gradient: &'a mut [Vec<T>],
}

impl<T: Float> WithSimd for WeightGradients<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        self.tape.add_weight_gradients(self.network, self.steps, self.gradient);
    }
}
