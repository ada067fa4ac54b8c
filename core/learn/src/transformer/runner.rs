//! `TransformerRunner`: one sample at a time, without tensors or allocation.

use hysteron_base::lanes::{Isa, Simd, WithSimd};

use super::cell::{gru, lstm};
use super::kernels::{Attention, add_scaled, gelu, norm, sigmoid, silu};
use super::network::Transformer;
use super::shape::{BlockKind, LayerLayout, TemporalForm, TransformerShape};
use crate::panels::{Panels, padded};
use crate::{TrainableModel, WeightFormat};

/// Steps of the streaming form between two moves of its kept tokens to the front.
const STRETCH: usize = 64;

/// A matrix and its bias, packed.
#[derive(Debug, Clone)]
struct PackedLinear {
    inputs: usize,
    weight: Panels,
    /// Filled up to whole panels.
    bias: Vec<f32>,
}

impl PackedLinear {
    /// From W (inputs × outputs).
    fn new([weight, bias]: [&[f32]; 2], format: WeightFormat) -> Self {
        let (outputs, inputs) = (bias.len(), weight.len() / bias.len());
        let transposed: Vec<f32> =
            (0..outputs).flat_map(|o| (0..inputs).map(move |i| weight[i * outputs + o])).collect();
        let mut full = padded(outputs);
        full[..outputs].copy_from_slice(bias);
        Self { inputs, weight: Panels::new(&transposed, inputs, format), bias: full }
    }

    /// The rows of `x` times W, plus b, into the beginning of `out`; their width there.
    fn run(&self, x: &[f32], out: &mut [f32]) -> usize {
        let width = self.bias.len();
        let out = &mut out[..x.len() / self.inputs * width];
        out.chunks_exact_mut(width).for_each(|row| row.copy_from_slice(&self.bias));
        self.weight.multiply_add_rows(self.inputs, x, out);
        width
    }
}

#[derive(Debug, Clone)]
struct RunnerLayer {
    linear: Vec<PackedLinear>,
    parameters: Vec<f32>,
    /// Queries, gates, keys and values of the tokens that are kept.
    projections: Vec<f32>,
    /// Hidden state and cell of a recurrent layer.
    memory: [Vec<f32>; 2],
}

/// A network that is stepped one sample at a time, for rollouts and controllers.
///
/// The published form goes through its whole window every step; before it is full, it repeats the first sample. The streaming form
/// goes through the new token alone. Both step as [`super::TransformerTape`] does to the round-off of `f32`; with
/// [`WeightFormat::Int16`], to that of its weights.
#[derive(Debug, Clone)]
pub struct TransformerRunner {
    shape: TransformerShape,
    layout: LayerLayout,
    input: PackedLinear,
    positions: Vec<f32>,
    layers: Vec<RunnerLayer>,
    norm: Option<[Vec<f32>; 2]>,
    latent: PackedLinear,
    heads: Vec<PackedLinear>,
    /// Steps since the tokens kept were moved to the front.
    step: usize,
    is_fresh: bool,
    /// Embedded tokens of a window, oldest first.
    window: Vec<f32>,
    tokens: Vec<f32>,
    /// Tokens after the last normalisation, of those kept.
    normed: Vec<f32>,
    scratch: RunnerScratch,
    outputs: Vec<f32>,
}

#[derive(Debug, Clone)]
struct RunnerScratch {
    wide: Vec<f32>,
    hidden: Vec<f32>,
    normalised: Vec<f32>,
    context: Vec<f32>,
    unit: Vec<f32>,
    rate: Vec<f32>,
    weights: Vec<f32>,
}

impl TransformerRunner {
    /// A runner with an empty context.
    pub fn new(network: &Transformer<f32>, format: WeightFormat) -> Self {
        let shape = network.shape().clone();
        let (layout, parameters) = (&network.layout, network.parameters());
        let linear = |values: &[f32], [weight, bias]: &[std::ops::Range<usize>; 2]| {
            PackedLinear::new([&values[weight.clone()], &values[bias.clone()]], format)
        };
        let head = &parameters[shape.layers + 1];
        // Tokens that are worked on at once, and those that are kept.
        let (now, kept) = match shape.form {
            TemporalForm::Window => (shape.tokens, shape.tokens),
            TemporalForm::Streaming => (1, shape.tokens + STRETCH),
        };
        let layer = |values: &Vec<f32>| RunnerLayer {
            linear: layout
                .layer
                .linear
                .iter()
                .filter(|pair| !pair[1].is_empty())
                .map(|pair| linear(values, pair))
                .collect(),
            memory: [vec![0.0; shape.width], vec![0.0; shape.width]],
            parameters: values.clone(),
            projections: vec![0.0; kept * shape.projected()],
        };
        let widest = [shape.projected(), shape.feed_forward, shape.width, shape.heads.len() * shape.latent];
        let widest = padded(widest.into_iter().max().unwrap_or(0)).len();
        let zeros = |n: usize| vec![0.0; n];
        let d = shape.width;
        Self {
            input: linear(&parameters[0], &layout.input),
            positions: layout.positions.clone().map_or(Vec::new(), |range| parameters[0][range].to_vec()),
            layers: parameters[1..=shape.layers].iter().map(layer).collect(),
            norm: layout.norm.as_ref().map(|pair| pair.clone().map(|range| head[range].to_vec())),
            latent: linear(head, &layout.latent),
            heads: layout.heads.iter().map(|own| linear(head, own)).collect(),
            layout: layout.layer.clone(),
            step: 0,
            is_fresh: true,
            window: zeros(shape.tokens * d),
            tokens: zeros(now * d),
            normed: zeros(kept * d),
            scratch: RunnerScratch {
                wide: zeros(now * widest),
                hidden: zeros(now * widest),
                normalised: zeros(now * d),
                context: zeros(now * d),
                unit: zeros(now * d),
                rate: zeros(now),
                weights: zeros(shape.attention_heads * shape.tokens),
            },
            outputs: zeros(shape.outputs()),
            shape,
        }
    }

    /// Resets the context and the memory.
    pub fn reset(&mut self) {
        (self.step, self.is_fresh) = (0, true);
        self.layers.iter_mut().flat_map(|layer| &mut layer.memory).for_each(|memory| memory.fill(0.0));
    }

    /// One sample further: the outputs of all heads.
    ///
    /// # Panics
    /// If `input` has not as many numbers as a token.
    pub fn step(&mut self, input: &[f32]) -> &[f32] {
        assert_eq!(input.len(), self.shape.inputs, "numbers of a token");
        let d = self.shape.width;
        self.input.run(input, &mut self.scratch.wide);
        match self.shape.form {
            TemporalForm::Streaming => {
                if self.step == self.shape.tokens + STRETCH {
                    self.move_to_front();
                }
                self.tokens.copy_from_slice(&self.scratch.wide[..d]);
            }
            TemporalForm::Window => {
                self.window.copy_within(d.., 0);
                let last = (self.shape.tokens - 1) * d;
                self.window[last..].copy_from_slice(&self.scratch.wide[..d]);
                if self.is_fresh {
                    self.window[..last]
                        .chunks_exact_mut(d)
                        .for_each(|row| row.copy_from_slice(&self.scratch.wide[..d]));
                }
                let both = self.window.iter().zip(&self.positions);
                for (token, (own, position)) in self.tokens.iter_mut().zip(both) {
                    *token = own + position;
                }
                self.step = self.shape.tokens - 1;
            }
        }
        self.is_fresh = false;
        Isa::detect().run(CompiledPass(self));
        self.step += 1;
        &self.outputs
    }

    /// Keeps the tokens that the next one attends to, and drops the rest.
    fn move_to_front(&mut self) {
        let kept = self.shape.tokens - 1;
        let keep = |values: &mut Vec<f32>, width: usize, step: usize| {
            values.copy_within((step - kept) * width..step * width, 0);
        };
        for layer in &mut self.layers {
            keep(&mut layer.projections, self.shape.projected(), self.step);
        }
        keep(&mut self.normed, self.shape.width, self.step);
        self.step = kept;
    }

    #[inline(always)]
    fn read_out(&mut self) {
        let d = self.shape.width;
        let now = self.tokens.len() / d;
        let first = self.step + 1 - now;
        let normed = &mut self.normed[first * d..][..now * d];
        match &self.norm {
            Some([weight, bias]) => {
                let RunnerScratch { unit, rate, .. } = &mut self.scratch;
                norm(&self.tokens, [weight, bias], unit, rate, normed);
            }
            None => normed.copy_from_slice(&self.tokens),
        }
        let pool = (self.step + 1).saturating_sub(self.shape.pooled())..self.step + 1;
        let per = 1.0 / pool.len() as f32;
        let pooled = &mut self.scratch.normalised[..d];
        pooled.fill(0.0);
        pool.for_each(|s| add_scaled(pooled, per, &self.normed[s * d..][..d]));
        self.latent.run(pooled, &mut self.scratch.wide);
        let latent = self.shape.latent;
        let RunnerScratch { wide, hidden, .. } = &mut self.scratch;
        let mut at = 0;
        for (k, head) in self.heads.iter().enumerate() {
            let own = &mut wide[k * latent..][..latent];
            own.iter_mut().for_each(|h| *h = silu(*h)[0]);
            let n = self.shape.heads[k];
            head.run(own, hidden);
            self.outputs[at..at + n].copy_from_slice(&hidden[..n]);
            at += n;
        }
    }
}

/// All layers and heads, compiled for each instruction set.
struct CompiledPass<'a>(&'a mut TransformerRunner);

impl WithSimd for CompiledPass<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let runner = self.0;
        for layer in &mut runner.layers {
            let about = (&runner.shape, &runner.layout);
            layer.run(about, runner.step, &mut runner.tokens, &mut runner.scratch);
        }
        runner.read_out();
    }
}

impl RunnerLayer {
    /// Advances the recurrent cell by the token and replaces the token by its hidden state.
    fn step_cell(&mut self, shape: &TransformerShape, token: &mut [f32], scratch: &mut RunnerScratch) {
        let d = shape.width;
        let [hidden, cell] = &mut self.memory;
        let RunnerScratch { wide, hidden: state, .. } = scratch;
        self.linear[0].run(token, wide);
        self.linear[1].run(hidden, state);
        for k in 0..d {
            hidden[k] = if shape.block == BlockKind::Gru {
                let [a, b] = [&wide, &state].map(|of| [0, 1, 2].map(|j: usize| of[j * d + k]));
                gru(a, b, hidden[k])[3]
            } else {
                let sums = [0, 1, 2, 3].map(|j: usize| wide[j * d + k] + state[j * d + k]);
                let [_, _, _, _, c, _, h] = lstm(sums, cell[k]);
                cell[k] = c;
                h
            };
        }
        token.copy_from_slice(hidden);
    }

    /// Replaces the tokens of the steps up to `step` by what the layer makes of them.
    #[inline(always)]
    fn run(
        &mut self,
        (shape, layout): (&TransformerShape, &LayerLayout),
        step: usize,
        tokens: &mut [f32],
        scratch: &mut RunnerScratch,
    ) {
        if shape.block.gates().is_some() {
            return self.step_cell(shape, tokens, scratch);
        }
        let (d, p) = (shape.width, shape.projected());
        let now = tokens.len() / d;
        let first = step + 1 - now;
        let values = &self.parameters;
        let norms = [0, 1].map(|k: usize| layout.norm[k].clone().map(|range| &values[range]));
        let scales =
            layout.scales.clone().map_or([1.0; 2], |range| [values[range.start], values[range.start + 1]]);
        let is_pre = shape.block == BlockKind::GatedPreNorm;
        let RunnerScratch { wide, hidden, normalised, context, unit, rate, weights } = scratch;
        if is_pre {
            norm(tokens, norms[0], unit, rate, normalised);
        } else {
            normalised.copy_from_slice(tokens);
        }
        let width = self.linear[0].run(normalised, wide);
        for (row, wide) in
            self.projections[first * p..].chunks_exact_mut(p).zip(wide.chunks_exact(width)).take(now)
        {
            row.copy_from_slice(&wide[..p]);
        }
        let attention = Attention {
            width: d,
            projected: p,
            heads: shape.attention_heads,
            rows: 1,
            lags: layout.lags.clone().map(|range| &values[range]),
            window: shape.tokens,
        };
        for (row, context) in context.chunks_exact_mut(d).take(now).enumerate() {
            let query = first + row;
            let among = match shape.form {
                TemporalForm::Window => 0..shape.tokens,
                TemporalForm::Streaming => (query + 1).saturating_sub(shape.tokens)..query + 1,
            };
            attention.attend(&self.projections, (query, 0), among, weights, context);
            if is_pre {
                let gates = &self.projections[query * p + d..][..d];
                context.iter_mut().zip(gates).for_each(|(c, gate)| *c *= sigmoid(*gate));
            }
        }
        let width = self.linear[1].run(&context[..now * d], wide);
        for (token, wide) in tokens.chunks_exact_mut(d).zip(wide.chunks_exact(width)) {
            add_scaled(token, scales[0], &wide[..d]);
        }
        norm(tokens, norms[usize::from(is_pre)], unit, rate, normalised);
        if !is_pre {
            tokens.copy_from_slice(normalised);
        }
        let (f, width) = (shape.feed_forward, self.linear[2].run(normalised, wide));
        for (hidden, wide) in hidden.chunks_exact_mut(f).zip(wide.chunks_exact(width)).take(now) {
            for (h, x) in hidden.iter_mut().zip(wide) {
                *h = if is_pre { gelu(*x)[0] } else { silu(*x)[0] };
            }
        }
        let width = self.linear[3].run(&hidden[..now * f], wide);
        for (token, wide) in tokens.chunks_exact_mut(d).zip(wide.chunks_exact(width)) {
            add_scaled(token, scales[1], &wide[..d]);
        }
        if !is_pre {
            normalised.copy_from_slice(tokens);
            norm(normalised, norms[1], unit, rate, tokens);
        }
    }
}
