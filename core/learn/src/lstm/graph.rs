//! The network on candle's tensors.
//!
//! On a processor an LSTM layer over a whole sequence is one operation of a candle graph with its own
//! backward pass; on any other device it is some operations for each step, with a hand-written backward pass
//! (`tensors.rs`). Candle's own cells, step by step, are the reference that both are checked and measured
//! against.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use candle_core::{CpuStorage, CustomOp2, Device, Layout, Shape as Dims, Storage, Tensor, Var};
use candle_nn::rnn::{LSTMConfig, LSTMState, RNN, lstm};
use candle_nn::{Module, VarBuilder};

use super::batch::{HeadOutputs, Memory, SequenceBatch};
use super::layer::{self, LstmTape, SequenceShape};
use super::network::LayerWeights;
use super::tensors::{self, ForwardValues};
use crate::on_device::{DeviceGradients, DeviceWeights, best_device, derivative};
use crate::{Architecture, Error, HeadActivation};

impl From<candle_core::Error> for Error {
    fn from(error: candle_core::Error) -> Self {
        Self::Tensors(error.to_string())
    }
}

/// How layers are computed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum LayerBackend {
    /// A layer over the whole sequence at once; on a processor only.
    Fused,
    /// A layer on whole tensors.
    Tensors,
    /// candle's own cell for every step.
    Unrolled,
}

/// A device and what it reuses from batch to batch.
#[derive(Debug)]
pub(crate) struct Graph {
    device: Device,
    cells: LayerBackend,
    /// One for each layer.
    tapes: Vec<Arc<Mutex<LstmTape>>>,
    /// Derivatives of at most this size become zero in the backward pass through fused layers.
    pub gradient_floor: f32,
}

/// One forward pass, on the device.
pub(crate) struct DevicePass {
    outputs: Tensor,
    by_hand: Option<ByHand>,
}

/// Tape of a pass through layers for which candle has no backward pass.
struct ByHand {
    layers: Vec<ForwardValues>,
    /// Dropout factors on the sequences into the second layer and so on.
    masks: Vec<Tensor>,
    /// Output of the last layer: where candle's derivatives end.
    hidden: Var,
}

impl Graph {
    /// The best device there is, with what is fastest on it.
    pub fn new(architecture: &Architecture) -> candle_core::Result<Self> {
        let device = best_device()?;
        let cells = if device.is_cpu() { LayerBackend::Fused } else { LayerBackend::Tensors };
        Ok(Self::with_cells(architecture, device, cells))
    }

    /// The operations of a card on the processor.
    #[cfg(test)]
    pub fn as_on_card(architecture: &Architecture) -> Self {
        Self::with_cells(architecture, Device::Cpu, LayerBackend::Tensors)
    }

    /// candle's own cells on the processor.
    pub fn unrolled(architecture: &Architecture) -> Self {
        Self::with_cells(architecture, Device::Cpu, LayerBackend::Unrolled)
    }

    fn with_cells(architecture: &Architecture, device: Device, cells: LayerBackend) -> Self {
        let tapes = (0..architecture.layers).map(|_| Arc::default()).collect();
        Self { device, cells, tapes, gradient_floor: 0.0 }
    }

    /// Whether this is no processor.
    pub fn is_on_card(&self) -> bool {
        !self.device.is_cpu()
    }

    /// Where passes are computed.
    pub fn device(&self) -> &Device {
        &self.device
    }

    /// Runs the batch; `memory` is carried over. `masks` are what sequences are multiplied by on the way into the second
    /// layer and so on; none without dropout.
    pub fn forward(
        &self,
        (architecture, weights): (&Architecture, &DeviceWeights),
        batch: &SequenceBatch<'_>,
        memory: &mut Memory,
        masks: &[Vec<f32>],
    ) -> candle_core::Result<DevicePass> {
        let parameters = weights.vectors();
        let n = batch.steps * batch.rows;
        let (mut layers, mut placed) = (Vec::new(), Vec::new());
        let mut x = Tensor::from_slice(batch.inputs, (n, architecture.inputs), &self.device)?;
        for layer in 0..architecture.layers {
            let shape = SequenceShape {
                steps: batch.steps,
                rows: batch.rows,
                inputs: architecture.layer_inputs(layer),
                hidden: architecture.hidden,
            };
            if let Some(mask) = layer.checked_sub(1).and_then(|l| masks.get(l)) {
                let mask = Tensor::from_slice(mask, (n, architecture.hidden), &self.device)?;
                x = (x * &mask)?;
                placed.push(mask);
            }
            let state = [&mut memory.h[layer], &mut memory.c[layer]];
            x = match self.cells {
                LayerBackend::Fused => {
                    let operation = FusedLayer {
                        shape,
                        h0: state[0].clone(),
                        c0: state[1].clone(),
                        input_gradient: if layer == 0 {
                            InputGradient::Unused
                        } else {
                            InputGradient::Wanted
                        },
                        tape: self.tapes[layer].clone(),
                        floor: self.gradient_floor,
                    };
                    fused(operation, &x, &parameters[layer], state)?
                }
                LayerBackend::Tensors => {
                    let own = parameters[layer].as_detached_tensor();
                    let (h, kept) = tensors::forward(shape, &x, &own, state)?;
                    layers.push(kept);
                    h
                }
                LayerBackend::Unrolled => unrolled(shape, &x, &parameters[layer], state)?,
            };
        }
        let mut by_hand = None;
        if self.cells == LayerBackend::Tensors {
            let hidden = Var::from_tensor(&x)?;
            x = hidden.as_tensor().clone();
            by_hand = Some(ByHand { layers, masks: placed, hidden });
        }
        if batch.outputs == HeadOutputs::Last {
            x = x.narrow(0, n - batch.rows, batch.rows)?;
        }
        Ok(DevicePass { outputs: head(architecture, &x, &parameters[architecture.layers])?, by_hand })
    }
}

impl DevicePass {
    /// The outputs, row by row.
    pub fn outputs(&self) -> candle_core::Result<Vec<f32>> {
        self.outputs.flatten_all()?.to_vec1()
    }

    /// The gradient by each vector of parameters, from the one by the outputs.
    pub fn gradients(
        self,
        weights: &DeviceWeights,
        d_outputs: &[f32],
    ) -> candle_core::Result<DeviceGradients> {
        let d_outputs = Tensor::from_slice(d_outputs, self.outputs.shape(), self.outputs.device())?;
        let found = (self.outputs * d_outputs)?.sum_all()?.backward()?;
        let Some(ByHand { layers, masks, hidden }) = self.by_hand else { return weights.gradients(&found) };
        // From the head down.
        let mut gradients = weights.vectors()[layers.len()..]
            .iter()
            .map(|own| derivative(&found, own))
            .collect::<candle_core::Result<Vec<_>>>()?;
        let mut by_hidden = derivative(&found, &hidden)?;
        for (layer, kept) in layers.iter().enumerate().rev() {
            let (own, by_inputs) = kept.backward(&by_hidden, layer > 0)?;
            gradients.push(own);
            let Some(by_inputs) = by_inputs else { break };
            by_hidden = match masks.get(layer - 1) {
                Some(mask) => (by_inputs * mask)?,
                None => by_inputs,
            };
        }
        gradients.reverse();
        Ok(DeviceGradients::new(gradients))
    }
}

fn head(architecture: &Architecture, h: &Tensor, parameters: &Tensor) -> candle_core::Result<Tensor> {
    let (outputs, hidden) = (architecture.outputs, architecture.hidden);
    let weight = parameters.narrow(0, 0, outputs * hidden)?.reshape((outputs, hidden))?;
    let bias = parameters.narrow(0, outputs * hidden, outputs)?;
    let output = candle_nn::Linear::new(weight, Some(bias)).forward(h)?;
    match architecture.head {
        HeadActivation::Linear => Ok(output),
        HeadActivation::Tanh => output.tanh(),
    }
}

/// A layer by candle's own cell; `state` is carried over.
fn unrolled(
    shape: SequenceShape,
    x: &Tensor,
    parameters: &Tensor,
    [h0, c0]: [&mut Vec<f32>; 2],
) -> candle_core::Result<Tensor> {
    let SequenceShape { steps, rows, inputs, hidden } = shape;
    let n_ih = 4 * hidden * inputs;
    let n_hh = 4 * hidden * hidden;
    let weights = [
        ("weight_ih_l0", parameters.narrow(0, 0, n_ih)?.reshape((4 * hidden, inputs))?),
        ("weight_hh_l0", parameters.narrow(0, n_ih, n_hh)?.reshape((4 * hidden, hidden))?),
        ("bias_ih_l0", parameters.narrow(0, n_ih + n_hh, 4 * hidden)?),
    ];
    let weights = weights.into_iter().map(|(name, tensor)| (name.to_owned(), tensor)).collect();
    let builder = VarBuilder::from_tensors(weights, candle_core::DType::F32, x.device());
    let cell = lstm(inputs, hidden, LSTMConfig { b_hh_init: None, ..LSTMConfig::default() }, builder)?;
    let tensor = |values: &[f32]| Tensor::from_slice(values, (rows, hidden), x.device());
    let mut state = LSTMState::new(tensor(h0)?, tensor(c0)?);
    let mut sequence = Vec::with_capacity(steps);
    for t in 0..steps {
        state = cell.step(&x.narrow(0, t * rows, rows)?, &state)?;
        sequence.push(state.h.clone());
    }
    *h0 = state.h.flatten_all()?.to_vec1()?;
    *c0 = state.c.flatten_all()?.to_vec1()?;
    Tensor::cat(&sequence, 0)
}

/// A layer in one operation; `state` is carried over.
fn fused(
    operation: FusedLayer,
    x: &Tensor,
    parameters: &Tensor,
    [h0, c0]: [&mut Vec<f32>; 2],
) -> candle_core::Result<Tensor> {
    let (shape, tape) = (operation.shape, operation.tape.clone());
    let h = x.apply_op2(parameters, operation)?;
    let last = (shape.steps - 1) * shape.rows;
    *h0 = h.narrow(0, last, shape.rows)?.flatten_all()?.to_vec1()?;
    c0.copy_from_slice(locked(&tape).last_cells(shape));
    Ok(h)
}

fn locked(tape: &Mutex<LstmTape>) -> MutexGuard<'_, LstmTape> {
    tape.lock().unwrap_or_else(PoisonError::into_inner)
}

#[derive(Debug, PartialEq)]
enum InputGradient {
    Wanted,
    /// The inputs of the first layer are data.
    Unused,
}

/// From (inputs, parameters) to the sequence of hidden states; the memory before it is a constant.
struct FusedLayer {
    shape: SequenceShape,
    h0: Vec<f32>,
    c0: Vec<f32>,
    input_gradient: InputGradient,
    tape: Arc<Mutex<LstmTape>>,
    floor: f32,
}

impl FusedLayer {
    fn weights<'a>(&self, parameters: &'a [f32]) -> LayerWeights<'a> {
        LayerWeights::new(parameters, self.shape.inputs, self.shape.hidden)
    }
}

/// The values of a contiguous tensor.
fn values<'a>(storage: &'a CpuStorage, layout: &Layout) -> candle_core::Result<&'a [f32]> {
    let Some((from, to)) = layout.contiguous_offsets() else {
        candle_core::bail!("an LSTM layer needs contiguous tensors")
    };
    Ok(&storage.as_slice()?[from..to])
}

/// Result of `work` on the values of some tensors on the processor.
fn with_values<T, const N: usize>(
    tensors: [&Tensor; N],
    work: impl FnOnce([&[f32]; N]) -> T,
) -> candle_core::Result<T> {
    let guards = tensors.map(Tensor::storage_and_layout);
    let mut slices: [&[f32]; N] = [&[]; N];
    for (slice, (storage, layout)) in slices.iter_mut().zip(&guards) {
        let Storage::Cpu(storage) = &**storage else {
            candle_core::bail!("an LSTM layer in one operation needs the processor")
        };
        *slice = values(storage, layout)?;
    }
    Ok(work(slices))
}

impl CustomOp2 for FusedLayer {
    fn name(&self) -> &'static str {
        "lstm-layer"
    }

    fn cpu_fwd(
        &self,
        x: &CpuStorage,
        x_layout: &Layout,
        parameters: &CpuStorage,
        parameters_layout: &Layout,
    ) -> candle_core::Result<(CpuStorage, Dims)> {
        let (x, parameters) = (values(x, x_layout)?, values(parameters, parameters_layout)?);
        let mut h = vec![0.0; self.shape.n_states()];
        let state = [&self.h0[..], &self.c0];
        layer::forward(self.shape, self.weights(parameters), x, state, &mut locked(&self.tape), &mut h);
        let dims = Dims::from((self.shape.steps * self.shape.rows, self.shape.hidden));
        Ok((CpuStorage::F32(h), dims))
    }

    fn bwd(
        &self,
        x: &Tensor,
        parameters: &Tensor,
        h: &Tensor,
        dh: &Tensor,
    ) -> candle_core::Result<(Option<Tensor>, Option<Tensor>)> {
        let mut d_parameters = vec![0.0; parameters.elem_count()];
        let mut dx = match self.input_gradient {
            InputGradient::Wanted => Some(vec![0.0; x.elem_count()]),
            InputGradient::Unused => None,
        };
        with_values([x, parameters, h, &dh.contiguous()?], |[x, parameters, h, dh]| {
            let weights = self.weights(parameters);
            let state = [&self.h0[..], &self.c0];
            let tape = &mut locked(&self.tape);
            let gradients =
                layer::LayerGradients { parameters: &mut d_parameters, inputs: dx.as_deref_mut() };
            layer::backward(self.shape, weights, [x, h, dh], state, tape, self.floor, gradients);
        })?;
        let dx = dx.map(|dx| Tensor::from_vec(dx, x.shape(), x.device())).transpose()?;
        Ok((dx, Some(Tensor::from_vec(d_parameters, parameters.shape(), parameters.device())?)))
    }
}
