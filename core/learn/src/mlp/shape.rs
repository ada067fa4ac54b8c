//! Multi-layer perceptrons: shapes, layout of the parameters, initialisation.
//!
//! A [`Mlp`] holds no parameters: they are one slice, so that several networks can be trained as one vector.

use hysteron_base::size::check_count;
use hysteron_base::{BadInput, rng};
use rand::RngExt;
use serde::{Deserialize, Serialize};

use super::activation::Activation;
use crate::engine::{MAX_HIDDEN, MAX_LAYERS};

/// The shape of a multi-layer perceptron: y = W_k f(… f(W_1 x + b_1) …) + b_k.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Mlp {
    /// Numbers that enter.
    pub inputs: usize,
    /// Units of every hidden layer.
    pub hidden: Vec<usize>,
    /// Numbers that leave.
    pub outputs: usize,
    /// Between the layers.
    pub activation: Activation,
    /// Whether a matrix S leads past the hidden layers: y + S x.
    #[serde(default)]
    pub skip: bool,
}

/// Ranges of one layer in the parameters.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct LayerShape {
    pub inputs: usize,
    pub outputs: usize,
    /// First of `outputs * inputs` weights, row by row (one row for each output), then `outputs` biases.
    pub start: usize,
}

impl LayerShape {
    /// Weights and biases.
    pub fn split<'a, T>(&self, parameters: &'a [T]) -> (&'a [T], &'a [T]) {
        parameters[self.start..self.end()].split_at(self.outputs * self.inputs)
    }

    pub fn weights_mut<'a, T>(&self, parameters: &'a mut [T]) -> &'a mut [T] {
        &mut parameters[self.start..self.start + self.outputs * self.inputs]
    }

    pub fn split_mut<'a, T>(&self, parameters: &'a mut [T]) -> (&'a mut [T], &'a mut [T]) {
        parameters[self.start..self.end()].split_at_mut(self.outputs * self.inputs)
    }

    fn end(&self) -> usize {
        self.start + self.outputs * (self.inputs + 1)
    }
}

impl Mlp {
    /// # Errors
    /// `BadInput` for a count of zero or one that no computer holds.
    pub fn check(&self) -> Result<(), BadInput> {
        check_count("mlp: inputs", self.inputs, MAX_HIDDEN)?;
        check_count("mlp: outputs", self.outputs, MAX_HIDDEN)?;
        check_count("mlp: hidden layers", self.hidden.len(), MAX_LAYERS)?;
        self.hidden.iter().try_for_each(|n| check_count("mlp: hidden units", *n, MAX_HIDDEN))
    }

    /// From the first layer to the last.
    pub(crate) fn layers(&self) -> Vec<LayerShape> {
        let widths: Vec<usize> =
            [self.inputs].into_iter().chain(self.hidden.iter().copied()).chain([self.outputs]).collect();
        let mut start = 0;
        widths
            .windows(2)
            .map(|pair| {
                let layer = LayerShape { inputs: pair[0], outputs: pair[1], start };
                start = layer.end();
                layer
            })
            .collect()
    }

    /// Where S begins; [output][input], after all layers.
    pub(crate) fn skip_start(&self) -> usize {
        self.layers().last().map_or(0, LayerShape::end)
    }

    /// How many parameters there are.
    pub fn n_parameters(&self) -> usize {
        self.skip_start() + if self.skip { self.inputs * self.outputs } else { 0 }
    }

    /// Parameters to begin with: biases zero, weights uniform with variance 1/inputs (2/inputs after ReLU), those of the
    /// last layer times `gain`, S zero. `stream` names the random stream of `seed`.
    ///
    /// # Reference
    /// LeCun et al. (1998), Efficient backprop, eq. 16; He et al. (2015), eq. 10, for ReLU.
    pub fn initial_parameters(&self, seed: u64, stream: &str, gain: f64) -> Vec<f64> {
        let mut rng = rng(seed, stream);
        let mut parameters = vec![0.0; self.n_parameters()];
        let layers = self.layers();
        for (l, layer) in layers.iter().enumerate() {
            let after = if self.activation == Activation::Relu && l > 0 { 2.0 } else { 1.0 };
            let last = if l + 1 == layers.len() { gain } else { 1.0 };
            let bound = last * (3.0 * after / layer.inputs as f64).sqrt();
            for weight in layer.split_mut(&mut parameters).0 {
                *weight = bound * rng.random_range(-1.0..1.0);
            }
        }
        parameters
    }
}
