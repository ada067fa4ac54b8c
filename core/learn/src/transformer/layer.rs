//! One layer over some steps of some sequences, forward and backward.
//!
//! Rows are time-major: token `s` of sequence `r` is row `s rows + r`. A pass handles a range of steps and leaves what came
//! before and after it alone, so that the streaming form advances token by token with stored keys and values.

use std::ops::Range;

use super::cell::{CellTape, RecurrentCell};
use super::kernels::{Attention, add_scaled, dot, gelu, norm, norm_back, sigmoid, silu};
use super::linear::{Linear, Packed, linear_gradient};
use super::network::Transformer;
use super::shape::{BlockKind, LayerLayout, TemporalForm, TransformerShape};
use crate::{Float, TrainableModel};

/// Values and derivatives of a layer in the forward and backward passes, for every token.
#[derive(Debug, Clone, Default)]
pub(super) struct LayerTape<T> {
    /// Normalised over each token and 1/spread, of both normalisations.
    unit: [Vec<T>; 2],
    rate: [Vec<T>; 2],
    /// Inputs of the attention's projections, and of the feed-forward network.
    normalised: Vec<T>,
    middle: Vec<T>,
    /// Queries, gates after their sigmoid, keys, values.
    projections: Vec<T>,
    /// Attention's weights (heads × tokens of a window).
    weights: Vec<T>,
    context: Vec<T>,
    gated: Vec<T>,
    attended: Vec<T>,
    sum: Vec<T>,
    hidden: Vec<T>,
    slope: Vec<T>,
    added: Vec<T>,
    d_projections: Vec<T>,
    d_attended: Vec<T>,
    d_hidden: Vec<T>,
    d_added: Vec<T>,
    /// Of a recurrent layer.
    cell: CellTape<T>,
    /// Scratch of the backward pass.
    d_weights: Vec<T>,
    d_token: [Vec<T>; 2],
}

/// A layer's parameters with their layout.
#[derive(Clone, Copy)]
pub(super) struct Layer<'a, T> {
    pub shape: &'a TransformerShape,
    pub layout: &'a LayerLayout,
    pub parameters: &'a [T],
    pub packed: &'a [Packed<T>],
    /// Sequences side by side.
    pub rows: usize,
}

impl<'a, T: Float> Layer<'a, T> {
    pub fn of(network: &'a Transformer<T>, layer: usize, rows: usize) -> Self {
        let (parameters, packed) = (&network.parameters()[1 + layer], &network.packed()[1 + layer]);
        Self { shape: network.shape(), layout: &network.layout.layer, parameters, packed, rows }
    }

    /// The recurrent cell that replaces attention in a layer with a state of its own.
    fn cell(&self) -> RecurrentCell<'a, T> {
        let [token, state] = [0, 1].map(|k| self.linear(k));
        RecurrentCell { shape: self.shape, token, state, rows: self.rows }
    }

    fn pair(&self, [weight, bias]: &[Range<usize>; 2]) -> [&'a [T]; 2] {
        [&self.parameters[weight.clone()], &self.parameters[bias.clone()]]
    }

    fn linear(&self, k: usize) -> Linear<'a, T> {
        Linear::of(self.parameters, self.packed, &self.layout.linear[k])
    }

    /// γ of attention and feed-forward network.
    fn scales(&self) -> [T; 2] {
        let of = |range: &Range<usize>| [self.parameters[range.start], self.parameters[range.start + 1]];
        self.layout.scales.as_ref().map_or([T::of(1.0); 2], of)
    }

    fn attention(&self) -> Attention<'a, T> {
        Attention {
            width: self.shape.width,
            projected: self.shape.projected(),
            heads: self.shape.attention_heads,
            rows: self.rows,
            lags: self.layout.lags.as_ref().map(|lags| &self.parameters[lags.clone()]),
            window: self.shape.tokens,
        }
    }

    /// The tokens that token `query` attends to.
    fn attended(&self, query: usize) -> Range<usize> {
        match self.shape.form {
            TemporalForm::Window => 0..self.shape.tokens,
            TemporalForm::Streaming => (query + 1).saturating_sub(self.shape.tokens)..query + 1,
        }
    }

    /// From the tokens `x` of all steps to `y`, at these steps.
    #[inline(always)]
    pub fn forward(&self, steps: Range<usize>, x: &[T], tape: &mut LayerTape<T>, y: &mut [T]) {
        if self.shape.block.gates().is_some() {
            return self.cell().forward(steps, x, &mut tape.cell, y);
        }
        let (d, f, p) = (self.shape.width, self.shape.feed_forward, self.shape.projected());
        let part = |width: usize| steps.start * self.rows * width..steps.end * self.rows * width;
        let (tokens, wide, one) = (part(d), part(f), part(1));
        let is_pre = self.shape.block == BlockKind::GatedPreNorm;
        let [first, second] = [0, 1].map(|k: usize| self.pair(&self.layout.norm[k]));
        let [w_in, w_out, w_up, w_down] = [0, 1, 2, 3].map(|k| self.linear(k));
        let x = &x[tokens.clone()];
        let t = tape;
        let normalised = &mut t.normalised[tokens.clone()];
        if is_pre {
            norm(x, first, &mut t.unit[0][tokens.clone()], &mut t.rate[0][one.clone()], normalised);
        } else {
            normalised.copy_from_slice(x);
        }
        w_in.forward(normalised, &mut t.projections[part(p)]);
        self.attend(steps, t);
        let attended = &mut t.attended[tokens.clone()];
        w_out.forward(&t.gated[tokens.clone()], attended);
        let [by_attention, by_feed_forward] = self.scales();
        let (sum, middle) = (&mut t.sum[tokens.clone()], &mut t.middle[tokens.clone()]);
        sum.copy_from_slice(x);
        add_scaled(sum, by_attention, attended);
        let which = usize::from(is_pre);
        let weights = if is_pre { second } else { first };
        norm(sum, weights, &mut t.unit[which][tokens.clone()], &mut t.rate[which][one.clone()], middle);
        let (hidden, slope) = (&mut t.hidden[wide.clone()], &mut t.slope[wide]);
        w_up.forward(middle, hidden);
        for (h, slope) in hidden.iter_mut().zip(slope) {
            [*h, *slope] = if is_pre { gelu(*h) } else { silu(*h) };
        }
        let added = &mut t.added[tokens.clone()];
        w_down.forward(hidden, added);
        if is_pre {
            y[tokens.clone()].copy_from_slice(sum);
            add_scaled(&mut y[tokens], T::of(1.0), added);
        } else {
            sum.copy_from_slice(middle);
            add_scaled(sum, by_feed_forward, added);
            norm(sum, second, &mut t.unit[1][tokens.clone()], &mut t.rate[1][one], &mut y[tokens]);
        }
    }

    #[inline(always)]
    fn attend(&self, steps: Range<usize>, t: &mut LayerTape<T>) {
        let (d, p) = (self.shape.width, self.shape.projected());
        let attention = self.attention();
        let of_row = attention.heads * attention.window;
        for s in steps {
            for r in 0..self.rows {
                let row = s * self.rows + r;
                let weights = &mut t.weights[row * of_row..][..of_row];
                let (context, gated) = (&mut t.context[row * d..][..d], &mut t.gated[row * d..][..d]);
                attention.attend(&t.projections, (s, r), self.attended(s), weights, context);
                if self.shape.block == BlockKind::GatedPreNorm {
                    let gates = &mut t.projections[row * p + d..][..d];
                    for ((gated, gate), context) in gated.iter_mut().zip(gates).zip(context) {
                        *gate = sigmoid(*gate);
                        *gated = *gate * *context;
                    }
                } else {
                    gated.copy_from_slice(context);
                }
            }
        }
    }

    /// From the gradient `dy` by the layer's result at these steps to that by its tokens, in its place; the
    /// backward pass has been through all later steps. `gradient` gets the part of normalisations, scalars
    /// and lags.
    #[inline(always)]
    pub fn backward(&self, steps: Range<usize>, tape: &mut LayerTape<T>, dy: &mut [T], gradient: &mut [T]) {
        if self.shape.block.gates().is_some() {
            return self.cell().backward(steps, &mut tape.cell, dy);
        }
        let (d, f, p) = (self.shape.width, self.shape.feed_forward, self.shape.projected());
        let part = |width: usize| steps.start * self.rows * width..steps.end * self.rows * width;
        let (tokens, wide, one) = (part(d), part(f), part(1));
        let n = dy.len();
        let is_pre = self.shape.block == BlockKind::GatedPreNorm;
        let [w_in, w_out, w_up, w_down] = [0, 1, 2, 3].map(|k| self.linear(k));
        let norms = [0, 1].map(|k: usize| self.pair(&self.layout.norm[k])[0]);
        let norm_part = |k: usize| self.layout.norm[k][0].start..self.layout.norm[k][1].end;
        let scales = self.scales();
        let t = tape;
        let [by_sum, scratch] = &mut t.d_token;
        let (by_sum, scratch) = (&mut by_sum[..n], &mut scratch[..n]);
        // By the second sum, and by what the feed-forward network has added to it.
        by_sum.fill(T::default());
        if is_pre {
            by_sum.copy_from_slice(dy);
        } else {
            let at = [&t.unit[1][tokens.clone()], &t.rate[1][one.clone()], dy];
            norm_back(at, norms[1], by_sum, &mut gradient[norm_part(1)]);
        }
        let d_added = &mut t.d_added[tokens.clone()];
        d_added.fill(T::default());
        add_scaled(d_added, scales[1], by_sum);
        if let Some(range) = &self.layout.scales {
            gradient[range.start + 1] += dot(by_sum, &t.added[tokens.clone()]);
        }
        let d_hidden = &mut t.d_hidden[wide.clone()];
        w_down.back(d_added, d_hidden);
        for (d, slope) in d_hidden.iter_mut().zip(&t.slope[wide]) {
            *d *= *slope;
        }
        w_up.back(d_hidden, scratch);
        // By the first sum, and by what attention has added to it.
        if is_pre {
            let at = [&t.unit[1][tokens.clone()], &t.rate[1][one.clone()], &*scratch];
            norm_back(at, norms[1], by_sum, &mut gradient[norm_part(1)]);
        } else {
            add_scaled(scratch, T::of(1.0), by_sum);
            by_sum.fill(T::default());
            let at = [&t.unit[0][tokens.clone()], &t.rate[0][one.clone()], &*scratch];
            norm_back(at, norms[0], by_sum, &mut gradient[norm_part(0)]);
        }
        let d_attended = &mut t.d_attended[tokens.clone()];
        d_attended.fill(T::default());
        add_scaled(d_attended, scales[0], by_sum);
        if let Some(range) = &self.layout.scales {
            gradient[range.start] += dot(by_sum, &t.attended[tokens.clone()]);
        }
        w_out.back(d_attended, scratch);
        self.attend_back(
            steps.clone(),
            [&t.weights, &t.context, &t.projections],
            scratch,
            (&mut t.d_projections, &mut t.d_weights),
            gradient,
        );
        dy.copy_from_slice(by_sum);
        w_in.back(&t.d_projections[part(p)], scratch);
        if is_pre {
            let at = [&t.unit[0][tokens], &t.rate[0][one], &*scratch];
            norm_back(at, norms[0], dy, &mut gradient[norm_part(0)]);
        } else {
            add_scaled(dy, T::of(1.0), scratch);
        }
    }

    /// From the gradient by the gated output of attention to that by the projections of all tokens attended
    /// to.
    #[inline(always)]
    fn attend_back(
        &self,
        steps: Range<usize>,
        [weights, context, projections]: [&[T]; 3],
        d_gated: &mut [T],
        (d_projections, d_weights): (&mut [T], &mut [T]),
        gradient: &mut [T],
    ) {
        let (d, p) = (self.shape.width, self.shape.projected());
        let attention = self.attention();
        let of_row = attention.heads * attention.window;
        let first = steps.start * self.rows;
        for row in first..steps.end * self.rows {
            let (s, r) = (row / self.rows, row % self.rows);
            let d_context = &mut d_gated[(row - first) * d..][..d];
            if self.shape.block == BlockKind::GatedPreNorm {
                let gates = &projections[row * p + d..][..d];
                let d_gates = &mut d_projections[row * p + d..][..d];
                let at = gates.iter().zip(&context[row * d..][..d]);
                for ((d_context, d_gate), (gate, context)) in d_context.iter_mut().zip(d_gates).zip(at) {
                    *d_gate = *d_context * *context * *gate * (T::of(1.0) - *gate);
                    *d_context *= *gate;
                }
            }
            let at = [projections, &weights[row * of_row..][..of_row], d_context];
            let d_lags = self.layout.lags.as_ref().map(|lags| &mut gradient[lags.clone()]);
            attention.attend_backward(at, (s, r), self.attended(s), d_projections, d_lags, d_weights);
        }
    }

    /// Adds what belongs to the matrices, of all `steps`.
    #[inline(always)]
    pub fn gradient(&self, steps: usize, tape: &LayerTape<T>, gradient: &mut [T]) {
        if self.shape.block.gates().is_some() {
            return self.cell().gradient(steps, &tape.cell, &self.layout.linear, gradient);
        }
        let n = |width: usize| steps * self.rows * width;
        let (d, f, p) = (self.shape.width, self.shape.feed_forward, self.shape.projected());
        let pairs = [
            [&tape.normalised[..n(d)], &tape.d_projections[..n(p)]],
            [&tape.gated[..n(d)], &tape.d_attended[..n(d)]],
            [&tape.middle[..n(d)], &tape.d_hidden[..n(f)]],
            [&tape.hidden[..n(f)], &tape.d_added[..n(d)]],
        ];
        for (pair, layout) in pairs.into_iter().zip(&self.layout.linear) {
            linear_gradient(pair, layout, gradient);
        }
    }
}

impl<T: Float> LayerTape<T> {
    pub fn new(shape: &TransformerShape, n_rows: usize) -> Self {
        let cell = CellTape::new(shape.block, shape.width, n_rows);
        // A recurrent layer needs nothing else.
        let n_rows = if shape.block.gates().is_some() { 0 } else { n_rows };
        let zeros = |width: usize| vec![T::default(); n_rows * width];
        let (d, f, p) = (shape.width, shape.feed_forward, shape.projected());
        Self {
            unit: [zeros(d), zeros(d)],
            rate: [zeros(1), zeros(1)],
            normalised: zeros(d),
            middle: zeros(d),
            projections: zeros(p),
            weights: zeros(shape.attention_heads * shape.tokens),
            context: zeros(d),
            gated: zeros(d),
            attended: zeros(d),
            sum: zeros(d),
            hidden: zeros(f),
            slope: zeros(f),
            added: zeros(d),
            d_projections: zeros(p),
            d_attended: zeros(d),
            d_hidden: zeros(f),
            d_added: zeros(d),
            cell,
            d_weights: vec![T::default(); shape.attention_heads * shape.tokens],
            d_token: [zeros(d), zeros(d)],
        }
    }

    /// Clears the gradients before a backward pass.
    pub fn clear_gradients(&mut self) {
        self.d_projections.fill(T::default());
        self.cell.clear_gradients();
    }
}
