//! A network: plain arrays of weights.

use hysteron_base::{BadInput, rng};
use rand::RngExt;

use serde::Serialize;

use crate::files::TensorFile;
use crate::{Architecture, TensorShape, TrainableModel};

/// The weights of a network.
#[derive(Debug, Clone, PartialEq)]
pub struct Network {
    pub(super) architecture: Architecture,
    /// For each layer W_ih (4H × inputs), W_hh (4H × H), bias (4H) in one vector, row-major, gates in the order
    /// input, forget, cell, output; then the head, weight (outputs × H) and bias (outputs).
    pub(crate) parameters: Vec<Vec<f32>>,
}

impl Network {
    /// A network with random weights: all from U(-1/√H, 1/√H), the defaults of PyTorch.
    ///
    /// The one bias of a layer is the sum of two such numbers, as it is where `bias_ih` and `bias_hh` are apart.
    /// Nothing is added to the bias of the forget gate. Each tensor has its own random stream.
    ///
    /// # Errors
    /// `BadInput` if a size is zero or above the accepted maximum, or the dropout not in [0, 1).
    pub fn new(architecture: &Architecture, seed: u64) -> crate::Result<Self> {
        architecture.check()?;
        let bound = 1.0 / (architecture.hidden as f32).sqrt();
        let draw = |tensor: &TensorShape| -> Vec<f32> {
            let mut stream = rng(seed, &format!("learn/weights/{}", tensor.name));
            let mut uniform = || stream.random_range(-bound..bound);
            match tensor.name.starts_with("lstm.bias") {
                true => (0..tensor.len()).map(|_| uniform() + uniform()).collect(),
                false => (0..tensor.len()).map(|_| uniform()).collect(),
            }
        };
        let tensors = architecture.tensors();
        let parameters = tensors.iter().map(|of| of.iter().flat_map(draw).collect()).collect();
        Ok(Self { architecture: architecture.clone(), parameters })
    }

    /// A network of this shape with the weights of a file.
    ///
    /// # Errors
    /// `BadInput` if the architecture is invalid, a tensor missing or of another shape, or a weight not finite or
    /// above the accepted maximum.
    pub(crate) fn take_from(file: &mut TensorFile, architecture: Architecture) -> Result<Self, BadInput> {
        architecture.check()?;
        let parameters = file.take_weights(&architecture.tensors())?;
        Ok(Self { architecture, parameters })
    }

    /// The shape of the network.
    pub fn architecture(&self) -> &Architecture {
        &self.architecture
    }

    /// Numbers that training changes.
    pub fn n_parameters(&self) -> usize {
        self.parameters.iter().map(Vec::len).sum()
    }
}

impl TrainableModel for Network {
    type Value = f32;

    const FAMILY: &'static str = "lstm";

    fn shape(&self) -> impl Serialize {
        &self.architecture
    }

    fn parameters(&self) -> &[Vec<f32>] {
        &self.parameters
    }

    fn parameters_mut(&mut self) -> &mut [Vec<f32>] {
        &mut self.parameters
    }

    fn tensors(&self) -> Vec<Vec<TensorShape>> {
        self.architecture.tensors()
    }
}

/// The parameters of a layer, apart.
#[derive(Clone, Copy)]
pub(crate) struct LayerWeights<'a> {
    /// 4H × inputs, row-major.
    pub ih: &'a [f32],
    /// 4H × H, row-major.
    pub hh: &'a [f32],
    /// 4H.
    pub bias: &'a [f32],
}

impl<'a> LayerWeights<'a> {
    pub fn new(parameters: &'a [f32], inputs: usize, hidden: usize) -> Self {
        let (ih, rest) = parameters.split_at(4 * hidden * inputs);
        let (hh, bias) = rest.split_at(4 * hidden * hidden);
        assert_eq!(bias.len(), 4 * hidden, "bias of a layer");
        Self { ih, hh, bias }
    }
}
