//! One LSTM layer over a whole sequence, forward and back through time, on plain arrays.
//!
//! The inputs of all steps go through W_ih in one product; only W_hh h runs step by step, for groups of rows
//! that need nothing of each other. Going back, ∂L/∂z of all steps replaces the gates, and gradients of weights
//! are one product over all steps. How the work is split depends on the shape alone, never on the number of
//! threads. Equations: `docs/learn.md`.

use rayon::prelude::*;

use super::gates::{GatesBackward, GatesForward};
use super::network::LayerWeights;
use crate::product::{multiply, multiply_add, rows};

/// Rows (of all steps) that one task multiplies by W_ih: large for the product, small against the whole.
const CHUNK: usize = 512;
/// Tasks that share the gradient of the weights, by rows of it.
const N_GRADIENT_TASKS: usize = 4;

/// Sizes of a layer's sequence.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct SequenceShape {
    pub steps: usize,
    pub rows: usize,
    pub inputs: usize,
    pub hidden: usize,
}

impl SequenceShape {
    /// Rows that run through the steps together: enough to multiply well, yet at least two groups to share.
    fn group(&self) -> usize {
        (self.rows / 2).clamp(8, 32)
    }

    /// Values in a sequence of hidden states.
    pub fn n_states(&self) -> usize {
        self.steps * self.rows * self.hidden
    }
}

/// Values of the forward pass that the backward pass needs; reused from batch to batch.
#[derive(Debug, Default)]
pub(crate) struct LstmTape {
    /// i, f, g, o, then ∂L/∂z; [step][row][gate][unit].
    gates: Vec<f32>,
    /// c, [step][row][unit].
    cells: Vec<f32>,
}

impl LstmTape {
    /// Cells after the last step, [row][unit].
    pub fn last_cells(&self, shape: SequenceShape) -> &[f32] {
        &self.cells[(shape.steps - 1) * shape.rows * shape.hidden..]
    }
}

/// The parts of a [step][row][channel] array that each group of rows owns, step by step.
fn by_group(values: &mut [f32], shape: SequenceShape, n_channels: usize) -> Vec<Vec<&mut [f32]>> {
    let mut groups: Vec<Vec<&mut [f32]>> = Vec::new();
    groups.resize_with(shape.rows.div_ceil(shape.group()), Vec::new);
    for step in values.chunks_exact_mut(shape.rows * n_channels) {
        for (group, part) in groups.iter_mut().zip(step.chunks_mut(shape.group() * n_channels)) {
            group.push(part);
        }
    }
    groups
}

/// Runs the layer: writes h, [step][row][unit], and the tape.
///
/// `x` is [step][row][input]; `h0` and `c0`, [row][unit], are the memory before the first step.
pub(crate) fn forward(
    shape: SequenceShape,
    weights: LayerWeights<'_>,
    x: &[f32],
    [h0, c0]: [&[f32]; 2],
    tape: &mut LstmTape,
    h: &mut [f32],
) {
    let n = shape.hidden;
    tape.gates.resize(4 * shape.n_states(), 0.0);
    tape.cells.resize(shape.n_states(), 0.0);
    let from_inputs = tape.gates.par_chunks_mut(CHUNK * 4 * n).zip(x.par_chunks(CHUNK * shape.inputs));
    from_inputs.for_each(|(gates, x)| {
        gates.chunks_exact_mut(4 * n).for_each(|row| row.copy_from_slice(weights.bias));
        multiply_add(gates, rows(x, shape.inputs), rows(weights.ih, shape.inputs).transpose());
    });
    let group = shape.group() * n;
    by_group(&mut tape.gates, shape, 4 * n)
        .into_par_iter()
        .zip(by_group(&mut tape.cells, shape, n))
        .zip(by_group(h, shape, n))
        .zip(h0.par_chunks(group).zip(c0.par_chunks(group)))
        .for_each(|(((gates, mut cells), mut h), (h0, c0))| {
            for (t, gates) in gates.into_iter().enumerate() {
                let (h_before, h) = h.split_at_mut(t);
                let (c_before, c) = cells.split_at_mut(t);
                let h_before: &[f32] = h_before.last().map_or(h0, |h| h);
                let c_before = c_before.last().map_or(c0, |c| c);
                multiply_add(gates, rows(h_before, n), rows(weights.hh, n).transpose());
                GatesForward { gates, c_before, c: c[0], h: h[0], hidden: n }.run();
            }
        });
}

/// Gradients that [`backward`] writes.
pub(crate) struct LayerGradients<'a> {
    /// By the parameters, as [`LayerWeights`] lie.
    pub parameters: &'a mut [f32],
    /// By the inputs, where they are asked for.
    pub inputs: Option<&'a mut [f32]>,
}

/// Back-propagates through time after [`forward`], as far as anything is left of the derivatives, of which
/// those of at most `floor` count as zero. The gates on the tape are used up.
///
/// `h` is what `forward` wrote and `dh` the gradient by it.
pub(crate) fn backward(
    shape: SequenceShape,
    weights: LayerWeights<'_>,
    [x, h, dh]: [&[f32]; 3],
    [h0, c0]: [&[f32]; 2],
    tape: &mut LstmTape,
    floor: f32,
    gradients: LayerGradients<'_>,
) {
    let n = shape.hidden;
    let LstmTape { gates, cells } = tape;
    let cells = &cells[..];
    let run_group = |(index, gates): (usize, &mut Vec<&mut [f32]>)| {
        let first = index * shape.group() * n;
        back_through_time(shape, weights.hh, gates, first, [cells, dh, c0], floor)
    };
    let mut groups = by_group(gates, shape, 4 * n);
    let begins: Vec<usize> = groups.par_iter_mut().enumerate().map(run_group).collect();
    let begin = begins.iter().copied().min().unwrap_or(0);
    for (gates, own) in groups.into_iter().zip(begins) {
        gates.into_iter().take(own).skip(begin).for_each(|gates| gates.fill(0.0));
    }
    let dz = &gates[begin * shape.rows * 4 * n..];
    gradient(shape, begin, [dz, x, h, h0], gradients.parameters);
    if let Some(dx) = gradients.inputs {
        let (before, dx) = dx.split_at_mut(begin * shape.rows * shape.inputs);
        before.fill(0.0);
        let chunks = dx.par_chunks_mut(CHUNK * shape.inputs).zip(dz.par_chunks(CHUNK * 4 * n));
        chunks.for_each(|(dx, dz)| multiply(dx, rows(dz, 4 * n), rows(weights.ih, shape.inputs)));
    }
}

/// The steps of one group of rows, last to first; its values begin at `first` in every [row][unit] array. Gives the step
/// down to which it went: before that nothing comes from above, and what came from later has vanished.
fn back_through_time(
    shape: SequenceShape,
    weights_hh: &[f32],
    gates: &mut [&mut [f32]],
    first: usize,
    [cells, dh, c0]: [&[f32]; 3],
    floor: f32,
) -> usize {
    let n = shape.hidden;
    let Some(size) = gates.first().map(|gates| gates.len() / 4) else { return 0 };
    let of_step = |values, t: usize| -> &[f32] {
        let values: &[f32] = values;
        &values[t * shape.rows * n + first..][..size]
    };
    let is_zero = |values: &[f32]| values.iter().all(|value| *value == 0.0);
    let from_above = (0..shape.steps).take_while(|&t| is_zero(of_step(dh, t))).count();
    let (mut dh_next, mut dc) = (vec![0.0; size], vec![0.0; size]);
    for (t, gates) in gates.iter_mut().enumerate().rev() {
        let c_before = if t == 0 { &c0[first..][..size] } else { of_step(cells, t - 1) };
        GatesBackward {
            gates,
            c_before,
            c: of_step(cells, t),
            dh_above: of_step(dh, t),
            dh_next: &dh_next,
            dc: &mut dc,
            hidden: n,
            floor,
        }
        .run();
        if t <= from_above && is_zero(gates) && is_zero(&dc) {
            return t;
        }
        multiply(&mut dh_next, rows(gates, 4 * n), rows(weights_hh, n));
    }
    0
}

/// ∂L/∂W_ih = Σ ∂L/∂z xᵀ, ∂L/∂W_hh = Σ ∂L/∂z h_beforeᵀ, ∂L/∂b = Σ ∂L/∂z, over all rows and the steps from `begin` on,
/// where `dz` begins.
fn gradient(shape: SequenceShape, begin: usize, [dz, x, h, h0]: [&[f32]; 4], d_parameters: &mut [f32]) {
    let (n, inputs) = (shape.hidden, shape.inputs);
    let (d_ih, rest) = d_parameters.split_at_mut(4 * n * inputs);
    let (d_hh, d_bias) = rest.split_at_mut(4 * n * n);
    let size = (4 * n).div_ceil(N_GRADIENT_TASKS);
    let (dz_first, dz_later) = dz.split_at(shape.rows * 4 * n);
    let x = &x[begin * shape.rows * inputs..];
    let (h_first, h_later) = match begin.checked_sub(1) {
        Some(before) => h[before * shape.rows * n..].split_at(shape.rows * n),
        None => (h0, h),
    };
    let h_later = &h_later[..h_later.len() - shape.rows * n];
    d_ih.par_chunks_mut(size * inputs)
        .zip(d_hh.par_chunks_mut(size * n))
        .zip(d_bias.par_chunks_mut(size))
        .enumerate()
        .for_each(|(task, ((d_ih, d_hh), d_bias))| {
            let (from, count) = (task * size, d_bias.len());
            let part = |dz| rows(dz, 4 * n).subcols(from, count).transpose();
            multiply(d_ih, part(dz), rows(x, inputs));
            multiply(d_hh, part(dz_first), rows(h_first, n));
            multiply_add(d_hh, part(dz_later), rows(h_later, n));
            d_bias.fill(0.0);
            for dz in dz.chunks_exact(4 * n) {
                for (sum, dz) in d_bias.iter_mut().zip(&dz[from..]) {
                    *sum += dz;
                }
            }
        });
}

#[cfg(test)]
mod tests {
    use hysteron_base::rng;
    use rand::RngExt;

    use super::*;

    const FLOOR: f32 = 1e-16;
    /// Three groups of 9, 9 and 1 rows.
    const SHAPE: SequenceShape = SequenceShape { steps: 120, rows: 19, inputs: 3, hidden: 5 };

    fn uniform(name: &str, n: usize) -> Vec<f32> {
        let mut stream = rng(1, name);
        (0..n).map(|_| stream.random_range(-0.5..0.5)).collect()
    }

    /// The gradient by parameters and inputs for a derivative of this size in the last step of the first group, and less in
    /// the others; in units of that size.
    fn gradient_of(size: f32, floor: f32) -> [Vec<f32>; 2] {
        let SequenceShape { steps, rows, inputs, hidden } = SHAPE;
        let parameters = uniform("parameters", 4 * hidden * (inputs + hidden + 1));
        let weights = LayerWeights::new(&parameters, inputs, hidden);
        let x = uniform("inputs", steps * rows * inputs);
        let memory = [uniform("h", rows * hidden), uniform("c", rows * hidden)];
        let memory = memory.each_ref().map(|values| &values[..]);
        let (mut tape, mut h, mut dh) =
            (LstmTape::default(), vec![0.0; SHAPE.n_states()], vec![0.0; SHAPE.n_states()]);
        forward(SHAPE, weights, &x, memory, &mut tape, &mut h);
        let last = (steps - 1) * rows * hidden;
        for (row, dh) in dh[last..].chunks_exact_mut(hidden).enumerate() {
            dh.fill(size * 0.5f32.powi(row as i32));
        }
        let mut found = [vec![0.0; parameters.len()], vec![0.0; x.len()]];
        let [d_parameters, dx] = &mut found;
        let gradients = LayerGradients { parameters: d_parameters, inputs: Some(dx) };
        backward(SHAPE, weights, [&x, &h, &dh], memory, &mut tape, floor, gradients);
        found.map(|values| values.iter().map(|value| value / size).collect())
    }

    #[test]
    fn the_way_back_ends_below_the_floor_and_misses_no_more_than_it() {
        // A gradient is linear in what it is made from, and powers of two are exact: all that differs is what vanishes.
        let (small, large) = (2f32.powi(-20), 2f32.powi(60));
        let [ended, whole] = [gradient_of(small, FLOOR), gradient_of(large, FLOOR)];
        let n_before = |[_, dx]: &[Vec<f32>; 2]| dx.iter().take_while(|value| **value == 0.0).count();
        let n_step = SHAPE.rows * SHAPE.inputs;
        assert!(n_before(&ended) > 10 * n_step, "{} steps before", n_before(&ended) / n_step);
        assert_eq!(n_before(&whole), 0);
        // What has vanished, from every step and row, times an input or state of at most 1.
        let lost = (SHAPE.steps * SHAPE.rows) as f32 * FLOOR / small;
        for (ended, whole) in ended.iter().flatten().zip(whole.iter().flatten()) {
            assert!((ended - whole).abs() <= lost + f32::EPSILON * whole.abs(), "{ended} {whole}");
        }
    }

    #[test]
    fn without_a_floor_no_derivative_is_lost() {
        // Powers of two are exact as long as nothing falls below what f32 holds: these are far above it, and a floor takes some.
        let [small, large] = [2f32.powi(40), 2f32.powi(60)].map(|size| gradient_of(size, 0.0));
        assert_eq!(small, large);
        assert_ne!(gradient_of(2f32.powi(-20), FLOOR), small);
    }
}
