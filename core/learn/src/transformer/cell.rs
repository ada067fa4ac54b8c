//! Recurrent layers in place of attention: GRU and LSTM, forward and backward, step by step.
//!
//! Both have a projection of the token and one of the hidden state before, A = x W + b and B = h' U + c:
//! ```text
//! GRU   z = σ(A_z + B_z)   r = σ(A_r + B_r)   n = tanh(A_n + r B_n)     h = (1 − z) n + z h'
//! LSTM  i, f, o = σ(A + B)   g = tanh(A_g + B_g)   c = f c' + i g   h = o tanh c
//! ```
//!
//! # Reference
//! Cho et al. (2014), with the reset gate after the product as in cuDNN and PyTorch; Hochreiter, Schmidhuber (1997), Gers et al. (2000).

use std::ops::Range;

use super::kernels::{add_scaled, sigmoid};
use super::linear::{Linear, linear_gradient};
use super::shape::{BlockKind, TransformerShape};
use crate::Float;

/// Values and derivatives of recurrent layers in the forward and backward passes, for every token.
#[derive(Debug, Clone, Default)]
pub(super) struct CellTape<T> {
    /// Projections of tokens, and of the hidden state before (gates × width).
    token: Vec<T>,
    state: Vec<T>,
    /// Tokens, and hidden states before them.
    inputs: Vec<T>,
    before: Vec<T>,
    hidden: Vec<T>,
    /// Gates after their activation.
    gates: Vec<T>,
    /// c, and its tanh.
    cell: Vec<T>,
    bent: Vec<T>,
    d_token: Vec<T>,
    d_state: Vec<T>,
    /// By hidden state and cell, from the step after.
    d_hidden: Vec<T>,
    d_cell: Vec<T>,
}

fn tanh<T: Float>(x: T) -> T {
    T::of(2.0) * sigmoid(T::of(2.0) * x) - T::of(1.0)
}

/// z, r, n and h of a unit from its projections A and B and the hidden state before.
pub(super) fn gru<T: Float>([a_z, a_r, a_n]: [T; 3], [b_z, b_r, b_n]: [T; 3], before: T) -> [T; 4] {
    let [z, r] = [sigmoid(a_z + b_z), sigmoid(a_r + b_r)];
    let n = tanh(a_n + r * b_n);
    [z, r, n, n + z * (before - n)]
}

/// i, f, o, g, c, tanh c and h of a unit from A + B and the cell before.
pub(super) fn lstm<T: Float>([i, f, o, g]: [T; 4], past: T) -> [T; 7] {
    let ([i, f, o], g) = ([i, f, o].map(sigmoid), tanh(g));
    let c = f * past + i * g;
    let bent = tanh(c);
    [i, f, o, g, c, bent, o * bent]
}

impl<T: Float> CellTape<T> {
    pub fn new(block: BlockKind, width: usize, n_rows: usize) -> Self {
        let Some(gates) = block.gates() else { return Self::default() };
        let [one, all] = [width, gates * width].map(|n| vec![T::default(); n_rows * n]);
        Self {
            token: all.clone(),
            state: all.clone(),
            inputs: one.clone(),
            before: one.clone(),
            hidden: one.clone(),
            gates: all.clone(),
            cell: one.clone(),
            bent: one.clone(),
            d_token: all.clone(),
            d_state: all,
            d_hidden: one.clone(),
            d_cell: one,
        }
    }

    pub fn clear_gradients(&mut self) {
        self.d_hidden.fill(T::default());
        self.d_cell.fill(T::default());
    }
}

/// A recurrent layer's parameters with their layout.
#[derive(Clone, Copy)]
pub(super) struct RecurrentCell<'a, T> {
    pub shape: &'a TransformerShape,
    /// Projections of the token and of the state before.
    pub token: Linear<'a, T>,
    pub state: Linear<'a, T>,
    /// Sequences side by side.
    pub rows: usize,
}

impl<T: Float> RecurrentCell<'_, T> {
    /// From the tokens `x` of all steps to hidden states `y`, at these steps.
    pub fn forward(&self, steps: Range<usize>, x: &[T], t: &mut CellTape<T>, y: &mut [T]) {
        let (d, rows) = (self.shape.width, self.rows);
        let wide = self.shape.projected();
        let all = steps.start * rows * d..steps.end * rows * d;
        t.inputs[all.clone()].copy_from_slice(&x[all]);
        let tokens = &x[steps.start * rows * d..steps.end * rows * d];
        self.token.forward(tokens, &mut t.token[steps.start * rows * wide..steps.end * rows * wide]);
        for s in steps {
            let (now, of_gates) = (s * rows * d..(s + 1) * rows * d, s * rows * wide..(s + 1) * rows * wide);
            if s > 0 {
                let past = (s - 1) * rows * d..s * rows * d;
                t.before[now.clone()].copy_from_slice(&t.hidden[past]);
            }
            self.state.forward(&t.before[now.clone()], &mut t.state[of_gates]);
            for row in s * rows..(s + 1) * rows {
                self.cell(row, t);
            }
            y[now.clone()].copy_from_slice(&t.hidden[now]);
        }
    }

    /// Gates and hidden state of one row.
    fn cell(&self, row: usize, t: &mut CellTape<T>) {
        let (d, wide) = (self.shape.width, self.shape.projected());
        let (token, state) = (&t.token[row * wide..][..wide], &t.state[row * wide..][..wide]);
        let gates = &mut t.gates[row * wide..][..wide];
        for k in 0..d {
            let at = row * d + k;
            if self.shape.block == BlockKind::Gru {
                let [a, b] = [token, state].map(|of| [0, 1, 2].map(|j: usize| of[j * d + k]));
                let [z, r, n, h] = gru(a, b, t.before[at]);
                (gates[k], gates[d + k], gates[2 * d + k]) = (z, r, n);
                t.hidden[at] = h;
            } else {
                let past = if row < self.rows { T::default() } else { t.cell[at - self.rows * d] };
                let sums = [0, 1, 2, 3].map(|j: usize| token[j * d + k] + state[j * d + k]);
                let [i, f, o, g, c, bent, h] = lstm(sums, past);
                (gates[k], gates[d + k], gates[2 * d + k], gates[3 * d + k]) = (i, f, o, g);
                (t.cell[at], t.bent[at], t.hidden[at]) = (c, bent, h);
            }
        }
    }

    /// From the gradient `dy` by the hidden states of these steps to that by their tokens, in its place; the
    /// backward pass has been through all later steps.
    pub fn backward(&self, steps: Range<usize>, t: &mut CellTape<T>, dy: &mut [T]) {
        let (d, rows, wide) = (self.shape.width, self.rows, self.shape.projected());
        let mut by_before = vec![T::default(); rows * d];
        for s in steps.clone().rev() {
            let (now, of_gates) = (s * rows * d..(s + 1) * rows * d, s * rows * wide..(s + 1) * rows * wide);
            let own = &dy[(s - steps.start) * rows * d..][..rows * d];
            add_scaled(&mut t.d_hidden[now], T::of(1.0), own);
            for row in s * rows..(s + 1) * rows {
                self.cell_back(row, t, &mut by_before[(row - s * rows) * d..][..d]);
            }
            if s > 0 {
                let past = &mut t.d_hidden[(s - 1) * rows * d..s * rows * d];
                add_scaled(past, T::of(1.0), &by_before);
                self.state.back(&t.d_state[of_gates], &mut by_before);
                add_scaled(past, T::of(1.0), &by_before);
            }
        }
        self.token.back(&t.d_token[steps.start * rows * wide..steps.end * rows * wide], dy);
    }

    /// By the projections of one row, from that by its hidden state; into `by_before` what goes to the hidden state before past all gates.
    fn cell_back(&self, row: usize, t: &mut CellTape<T>, by_before: &mut [T]) {
        let (d, wide, one) = (self.shape.width, self.shape.projected(), T::of(1.0));
        let gates = &t.gates[row * wide..][..wide];
        let d_token = &mut t.d_token[row * wide..][..wide];
        let d_state = &mut t.d_state[row * wide..][..wide];
        let open = |gate: T| gate * (one - gate);
        for k in 0..d {
            let (at, dh) = (row * d + k, t.d_hidden[row * d + k]);
            if self.shape.block == BlockKind::Gru {
                let [z, r, n] = [0, 1, 2].map(|j: usize| gates[j * d + k]);
                let by_n = dh * (one - z) * (one - n * n);
                let by_r = by_n * t.state[row * wide + 2 * d + k] * open(r);
                let by_z = dh * (t.before[at] - n) * open(z);
                (d_token[k], d_token[d + k], d_token[2 * d + k]) = (by_z, by_r, by_n);
                (d_state[k], d_state[d + k], d_state[2 * d + k]) = (by_z, by_r, by_n * r);
                by_before[k] = dh * z;
            } else {
                let [i, f, o, g] = [0, 1, 2, 3].map(|j: usize| gates[j * d + k]);
                let by_cell = t.d_cell[at] + dh * o * (one - t.bent[at] * t.bent[at]);
                let is_first = row < self.rows;
                let past = if is_first { T::default() } else { t.cell[at - self.rows * d] };
                let by = [by_cell * g * open(i), by_cell * past * open(f), dh * t.bent[at] * open(o)];
                (d_token[k], d_token[d + k], d_token[2 * d + k]) = (by[0], by[1], by[2]);
                d_token[3 * d + k] = by_cell * i * (one - g * g);
                if !is_first {
                    t.d_cell[at - self.rows * d] += by_cell * f;
                }
                by_before[k] = T::default();
            }
        }
        if self.shape.block == BlockKind::Lstm {
            d_state.copy_from_slice(d_token);
        }
    }

    /// Adds what belongs to the matrices, whose weights and biases are at `layout`, of all `steps`.
    #[inline(always)]
    pub fn gradient(
        &self,
        steps: usize,
        t: &CellTape<T>,
        layout: &[[Range<usize>; 2]; 4],
        gradient: &mut [T],
    ) {
        let n = |width: usize| steps * self.rows * width;
        let (d, wide) = (self.shape.width, self.shape.projected());
        linear_gradient([&t.inputs[..n(d)], &t.d_token[..n(wide)]], &layout[0], gradient);
        linear_gradient([&t.before[..n(d)], &t.d_state[..n(wide)]], &layout[1], gradient);
    }
}
