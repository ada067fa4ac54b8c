//! One sample at a time, without tensors or allocation.

use super::gates::GatesForward;
use super::network::LayerWeights;
use crate::panels::{Panels, padded};
use crate::{HeadActivation, Network, WeightFormat};

#[derive(Debug, Clone)]
struct LstmRunnerLayer {
    from_input: Panels,
    from_memory: Panels,
    /// 4H, padded.
    bias: Vec<f32>,
    h: Vec<f32>,
    c: Vec<f32>,
}

/// A network with its memory, stepped one sample at a time, for rollouts and controllers.
///
/// Steps as [`crate::Backprop::predict`] does for one row, to the round-off of `f32`; with [`WeightFormat::Int16`], to that of
/// its weights.
#[derive(Debug, Clone)]
pub struct NetworkRunner {
    inputs: usize,
    hidden: usize,
    layers: Vec<LstmRunnerLayer>,
    head: Panels,
    /// As many as outputs, padded.
    head_bias: Vec<f32>,
    kind: HeadActivation,
    /// 4H, padded.
    gates: Vec<f32>,
    /// H; cells before the step.
    c_before: Vec<f32>,
    /// As many as outputs, padded.
    output: Vec<f32>,
    n_outputs: usize,
}

impl NetworkRunner {
    /// A runner with nothing remembered and weights as they were trained. Dropout does not act.
    pub fn new(network: &Network) -> Self {
        Self::with_weights(network, WeightFormat::Float32)
    }

    /// As [`NetworkRunner::new`], with weights in another format.
    pub fn with_weights(network: &Network, format: WeightFormat) -> Self {
        let architecture = network.architecture();
        let hidden = architecture.hidden;
        let pad = |values: &[f32]| {
            let mut all = padded(values.len());
            all[..values.len()].copy_from_slice(values);
            all
        };
        let layer = |(l, parameters): (usize, &Vec<f32>)| {
            let inputs = architecture.layer_inputs(l);
            let weights = LayerWeights::new(parameters, inputs, hidden);
            LstmRunnerLayer {
                from_input: Panels::new(weights.ih, inputs, format),
                from_memory: Panels::new(weights.hh, hidden, format),
                bias: pad(weights.bias),
                h: vec![0.0; hidden],
                c: vec![0.0; hidden],
            }
        };
        let layers = network.parameters[..architecture.layers].iter().enumerate().map(layer).collect();
        let (head, head_bias) =
            network.parameters[architecture.layers].split_at(architecture.outputs * hidden);
        Self {
            inputs: architecture.inputs,
            hidden,
            layers,
            head: Panels::new(head, hidden, format),
            head_bias: pad(head_bias),
            kind: architecture.head,
            gates: padded(4 * hidden),
            c_before: vec![0.0; hidden],
            output: padded(architecture.outputs),
            n_outputs: architecture.outputs,
        }
    }

    /// One sample further: the outputs of the head.
    ///
    /// # Panics
    /// If `input` has not as many channels as the network.
    pub fn step(&mut self, input: &[f32]) -> &[f32] {
        assert_eq!(input.len(), self.inputs, "channels of the input");
        let mut x = input;
        for layer in &mut self.layers {
            self.gates.copy_from_slice(&layer.bias);
            layer.from_input.multiply_add(x, &mut self.gates);
            layer.from_memory.multiply_add(&layer.h, &mut self.gates);
            self.c_before.copy_from_slice(&layer.c);
            GatesForward {
                gates: &mut self.gates[..4 * self.hidden],
                c_before: &self.c_before,
                c: &mut layer.c,
                h: &mut layer.h,
                hidden: self.hidden,
            }
            .run();
            x = &layer.h;
        }
        self.output.copy_from_slice(&self.head_bias);
        self.head.multiply_add(x, &mut self.output);
        let output = &mut self.output[..self.n_outputs];
        if self.kind == HeadActivation::Tanh {
            output.iter_mut().for_each(|v| *v = v.tanh());
        }
        output
    }

    /// Resets the memory to zero.
    pub fn reset(&mut self) {
        for layer in &mut self.layers {
            layer.h.fill(0.0);
            layer.c.fill(0.0);
        }
    }
}
