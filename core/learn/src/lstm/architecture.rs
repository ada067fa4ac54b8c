//! The shape of a network: LSTM layers one on the other, and a linear head.

use hysteron_base::BadInput;
use hysteron_base::size::check_memory;
use serde::{Deserialize, Serialize};

use crate::TensorShape;
use crate::engine::MAX_LAYERS;

/// Largest number of channels that is accepted, so that products of sizes cannot overflow.
const LARGEST: usize = 1 << 20;

/// Activation of the head, after its linear map.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum HeadActivation {
    /// Nothing.
    Linear,
    /// tanh, so that outputs stay in (-1, 1).
    Tanh,
}

impl HeadActivation {
    /// Name as in a checkpoint.
    pub fn name(self) -> &'static str {
        match self {
            Self::Linear => "linear",
            Self::Tanh => "tanh",
        }
    }
}

/// The shape of a network.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Architecture {
    /// Channels that enter.
    pub inputs: usize,
    /// Hidden units H of each layer.
    pub hidden: usize,
    /// LSTM layers.
    pub layers: usize,
    /// Channels that leave the head.
    pub outputs: usize,
    /// Activation of the head.
    pub head: HeadActivation,
    /// Probability p that a value between two layers is zero while training; the others grow by 1/(1 - p).
    pub dropout: f64,
}

impl std::fmt::Display for Architecture {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { inputs, hidden, layers, outputs, head, .. } = self;
        write!(f, "{inputs} inputs, {layers} layers of {hidden}, {outputs} outputs, head {}", head.name())
    }
}

impl Architecture {
    /// # Errors
    /// `BadInput` unless every size is in 1..=2²⁰ and 0 <= dropout < 1.
    pub(crate) fn check(&self) -> Result<(), BadInput> {
        let sizes = [
            ("inputs", self.inputs),
            ("hidden", self.hidden),
            ("layers", self.layers),
            ("outputs", self.outputs),
        ];
        for (name, size) in sizes {
            let largest = if name == "layers" { MAX_LAYERS } else { LARGEST };
            if !(1..=largest).contains(&size) {
                let place = format!("architecture: {name}");
                return Err(BadInput::new(place, format!("1 to {largest}"), size.to_string()));
            }
        }
        if !(0.0..1.0).contains(&self.dropout) {
            let found = self.dropout.to_string();
            return Err(BadInput::new("architecture: dropout", "0 <= p < 1", found));
        }
        Ok(())
    }

    /// Accepts a training of networks of this shape, `n_networks` at a time, in which so many rows of so many samples go
    /// through each at once.
    ///
    /// # Errors
    /// `BadInput` for a size above the accepted maximum, or one that this machine has no memory for.
    pub fn check_training(&self, [samples, rows]: [usize; 2], n_networks: usize) -> Result<(), BadInput> {
        self.check()?;
        let [inputs, hidden, layers, outputs] =
            [self.inputs, self.hidden, self.layers, self.outputs].map(|size| size as f64);
        let weights = 4.0 * hidden * (inputs + hidden * (2.0 * layers - 1.0) + layers) + outputs * hidden;
        // Of each weight: itself, mean, best, gradient and both moments, and two in passing. Of each unit in each sample:
        // four gates, cell, output, and what goes back through them.
        let values =
            8.0 * weights + (12.0 * hidden * layers + 4.0 * (inputs + outputs)) * (samples * rows) as f64;
        let bytes = 4.0 * values * n_networks as f64;
        check_memory("training", bytes, "fewer hidden units, windows of a step or samples at a time")
    }

    /// Channels that enter a layer.
    pub(crate) fn layer_inputs(&self, layer: usize) -> usize {
        if layer == 0 { self.inputs } else { self.hidden }
    }

    /// The parameters: for each layer, then for the head, the named arrays of one vector, in order.
    pub(crate) fn tensors(&self) -> Vec<Vec<TensorShape>> {
        let h = self.hidden;
        let layer = |l: usize| {
            vec![
                TensorShape::new(format!("lstm.weight_ih_l{l}"), &[4 * h, self.layer_inputs(l)]),
                TensorShape::new(format!("lstm.weight_hh_l{l}"), &[4 * h, h]),
                TensorShape::new(format!("lstm.bias_l{l}"), &[4 * h]),
            ]
        };
        let head = vec![
            TensorShape::new("head.weight", &[self.outputs, h]),
            TensorShape::new("head.bias", &[self.outputs]),
        ];
        (0..self.layers).map(layer).chain([head]).collect()
    }
}
