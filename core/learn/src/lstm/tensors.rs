//! An LSTM layer over a whole sequence by operations on whole tensors, forward and back by hand: what a card computes.
//!
//! A card waits for the next operation longer than it computes one. So what can be done for all steps at once is, and a step is nine
//! operations forward and eight back, a third of what candle's cell and its derivatives take. With σ alone
//! for all gates, as tanh p = 2 σ(2 p) - 1: the candidate's rows of weights and bias are doubled.

use candle_core::{Result, Tensor};
use candle_nn::ops::sigmoid;

use super::layer::SequenceShape;

/// Values of a forward pass that the backward pass needs.
pub(super) struct ForwardValues {
    /// Inputs (steps · rows × inputs).
    inputs: Tensor,
    /// Hidden states before every step and after the last (steps + 1 × rows × hidden).
    hidden: Tensor,
    /// Of every step σ of all gates (rows × 4 × hidden): input, forget, candidate, output.
    gates: Vec<Tensor>,
    /// Cells before every step and after the last (rows × hidden).
    cells: Vec<Tensor>,
    weights: LayerTensors,
}

/// The weights of a layer, the rows of the candidate doubled.
struct LayerTensors {
    /// 4 hidden × inputs, and 4 hidden × hidden.
    of_inputs: Tensor,
    of_hidden: Tensor,
    bias: Tensor,
    /// Factors on the rows (4 · hidden): 2 for the candidate, whose tanh is computed by σ, and 1 for the
    /// gates.
    factors: Tensor,
}

impl LayerTensors {
    fn new(shape: SequenceShape, parameters: &Tensor) -> Result<Self> {
        let SequenceShape { inputs, hidden, .. } = shape;
        let factors: Vec<f32> = (0..4 * hidden).map(|k| if k / hidden == 2 { 2.0 } else { 1.0 }).collect();
        let factors = Tensor::from_vec(factors, 4 * hidden, parameters.device())?;
        let rows = factors.unsqueeze(1)?;
        let (n_inputs, n_hidden) = (4 * hidden * inputs, 4 * hidden * hidden);
        let part = |from: usize, columns: usize| {
            parameters.narrow(0, from, 4 * hidden * columns)?.reshape((4 * hidden, columns))
        };
        Ok(Self {
            of_inputs: part(0, inputs)?.broadcast_mul(&rows)?,
            of_hidden: part(n_inputs, hidden)?.broadcast_mul(&rows)?,
            bias: (parameters.narrow(0, n_inputs + n_hidden, 4 * hidden)? * &factors)?,
            factors,
        })
    }
}

/// One gate of all four (rows × hidden, or steps × rows × hidden).
fn gate(gates: &Tensor, which: usize) -> Result<Tensor> {
    let along = gates.dims().len() - 2;
    gates.narrow(along, which, 1)?.squeeze(along)
}

/// Hidden states (steps · rows × hidden) from `inputs` (steps · rows × inputs); `state`, hidden states and cells, is carried over.
///
/// # Errors
/// The device refuses.
pub(super) fn forward(
    shape: SequenceShape,
    inputs: &Tensor,
    parameters: &Tensor,
    state: [&mut Vec<f32>; 2],
) -> Result<(Tensor, ForwardValues)> {
    let SequenceShape { steps, rows, hidden, .. } = shape;
    let device = inputs.device();
    let weights = LayerTensors::new(shape, parameters)?;
    let of_inputs = inputs.matmul(&weights.of_inputs.t()?)?.broadcast_add(&weights.bias)?;
    let of_hidden = weights.of_hidden.t()?.contiguous()?;
    let [mut h, mut c] = [
        Tensor::from_slice(state[0], (rows, hidden), device)?,
        Tensor::from_slice(state[1], (rows, hidden), device)?,
    ];
    let (mut all_h, mut all_c, mut all_gates) = (vec![h.clone()], vec![c.clone()], Vec::with_capacity(steps));
    for t in 0..steps {
        let z = (of_inputs.narrow(0, t * rows, rows)? + h.matmul(&of_hidden)?)?;
        let gates = sigmoid(&z)?.reshape((rows, 4, hidden))?;
        let candidate = gate(&gates, 2)?.affine(2.0, -1.0)?;
        c = ((gate(&gates, 1)? * &c)? + (gate(&gates, 0)? * candidate)?)?;
        h = (gate(&gates, 3)? * c.tanh()?)?;
        all_h.push(h.clone());
        all_c.push(c.clone());
        all_gates.push(gates);
    }
    let [end_h, end_c] = state;
    *end_h = h.flatten_all()?.to_vec1()?;
    *end_c = c.flatten_all()?.to_vec1()?;
    let all_h = Tensor::stack(&all_h, 0)?;
    let outputs = all_h.narrow(0, 1, steps)?.reshape((steps * rows, hidden))?;
    let forward_values =
        ForwardValues { inputs: inputs.clone(), hidden: all_h, gates: all_gates, cells: all_c, weights };
    Ok((outputs, forward_values))
}

/// Factors on derivatives by hidden states and cells after a step, for all steps at once.
struct Slopes {
    /// Of the gates' sums by the cells, and by the hidden states (steps × rows × 4 × hidden).
    by_cells: Tensor,
    by_hidden: Tensor,
    /// Of a cell by the hidden state that came of it, and by the cell after (steps × rows × hidden).
    cells_by_hidden: Tensor,
    cells_by_next: Tensor,
}

impl Slopes {
    fn new(forward_values: &ForwardValues) -> Result<Self> {
        let (gates, cells) =
            (Tensor::stack(&forward_values.gates, 0)?, Tensor::stack(&forward_values.cells, 0)?);
        let steps = forward_values.gates.len();
        let [input, forget, candidate, output] =
            [gate(&gates, 0)?, gate(&gates, 1)?, gate(&gates, 2)?, gate(&gates, 3)?];
        let curved = cells.narrow(0, 1, steps)?.tanh()?;
        let zero = curved.zeros_like()?;
        let slope = (&gates * gates.affine(-1.0, 1.0)?)?;
        let by = |parts: [&Tensor; 4]| Tensor::stack(&parts, 2)? * &slope;
        let [tanh, twice] = [candidate.affine(2.0, -1.0)?, input.affine(2.0, 0.0)?];
        Ok(Self {
            by_cells: by([&tanh, &cells.narrow(0, 0, steps)?, &twice, &zero])?,
            by_hidden: by([&zero, &zero, &zero, &curved])?,
            cells_by_hidden: (output * curved.sqr()?.affine(-1.0, 1.0)?)?,
            cells_by_next: forget.contiguous()?,
        })
    }
}

impl ForwardValues {
    /// The derivatives by the layer's parameters, and, where asked for, by its inputs, from those by its
    /// hidden states; the memory before it is a constant.
    ///
    /// # Errors
    /// The device refuses.
    pub fn backward(&self, by_outputs: &Tensor, wants_inputs: bool) -> Result<(Tensor, Option<Tensor>)> {
        let (_, rows, hidden) = self.hidden.dims3()?;
        let steps = self.gates.len();
        let slopes = Slopes::new(self)?;
        let of_step = |all: &Tensor, t: usize| all.narrow(0, t, 1)?.squeeze(0);
        let mut by_h = of_step(&by_outputs.reshape((steps, rows, hidden))?, steps - 1)?;
        let mut by_c: Option<Tensor> = None;
        let mut by_sums = Vec::with_capacity(steps);
        for t in (0..steps).rev() {
            let through = (&by_h * of_step(&slopes.cells_by_hidden, t)?)?;
            let to_c = by_c.map_or(Ok(through.clone()), |own| own + &through)?;
            let of_c = to_c.unsqueeze(1)?.broadcast_mul(&of_step(&slopes.by_cells, t)?)?;
            let sums = (of_c + by_h.unsqueeze(1)?.broadcast_mul(&of_step(&slopes.by_hidden, t)?)?)?;
            let sums = sums.reshape((rows, 4 * hidden))?;
            if t > 0 {
                let before = by_outputs.narrow(0, (t - 1) * rows, rows)?;
                by_h = (before + sums.matmul(&self.weights.of_hidden)?)?;
            }
            by_c = Some((to_c * of_step(&slopes.cells_by_next, t)?)?);
            by_sums.push(sums);
        }
        by_sums.reverse();
        let by_sums = Tensor::cat(&by_sums, 0)?;
        let before = self.hidden.narrow(0, 0, steps)?.reshape((steps * rows, hidden))?;
        let columns = by_sums.t()?;
        let factors = self.weights.factors.unsqueeze(1)?;
        let by_weights = |of: &Tensor| columns.matmul(of)?.broadcast_mul(&factors)?.flatten_all();
        let by_bias = (by_sums.sum(0)? * &self.weights.factors)?;
        let by_parameters = Tensor::cat(&[by_weights(&self.inputs)?, by_weights(&before)?, by_bias], 0)?;
        let by_inputs = wants_inputs.then(|| by_sums.matmul(&self.weights.of_inputs)).transpose()?;
        Ok((by_parameters, by_inputs))
    }
}
