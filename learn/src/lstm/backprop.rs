//! Passes of an LSTM network over batches: outputs, and the gradient of a loss by back-propagation through time.

use hysteron_base::rng;
use rand::RngExt;

use super::graph::Graph;
use crate::{Architecture, Batch, Error, Memory, Network, Result, Training};

/// What passes of networks of one architecture need, reused from batch to batch. Runs on the processor, or with the feature
/// `cuda` on the first NVIDIA card there is.
#[derive(Debug)]
pub struct Backprop {
    graph: Graph,
    /// Of dropout.
    seed: u64,
}

impl Backprop {
    /// Passes of networks of this architecture; `seed` is for dropout.
    ///
    /// # Errors
    /// `Tensors` if a card refuses.
    pub fn new(architecture: &Architecture, seed: u64) -> Result<Self> {
        Ok(Self { graph: Graph::new(architecture)?, seed })
    }

    /// As [`Backprop::new`], with candle's own cells on the processor: what other devices do, many times slower
    /// here. The fused layers are measured and checked against it.
    pub fn unrolled(architecture: &Architecture, seed: u64) -> Self {
        Self { graph: Graph::unrolled(architecture), seed }
    }

    /// Seed of dropout.
    pub(super) fn seed(&self) -> u64 {
        self.seed
    }

    /// Derivatives of at most this size become zero from the next pass on, see [`crate::WindowOptions::gradient_floor`]; none do
    /// at zero, as at first. Acts on the processor.
    ///
    /// # Panics
    /// If it is negative or not finite.
    pub fn set_gradient_floor(&mut self, floor: f32) {
        assert!(floor >= 0.0 && floor.is_finite(), "floor of derivatives: {floor}");
        self.graph.gradient_floor = floor;
    }

    /// The outputs for a batch, without dropout: [step][row][channel], or [row][channel] for
    /// [`crate::Outputs::Last`]. `memory` goes on.
    ///
    /// # Errors
    /// `BadInput` if batch or memory do not fit the network or an input is not finite.
    pub fn predict(&self, network: &Network, batch: &Batch<'_>, memory: &mut Memory) -> Result<Vec<f32>> {
        batch.check(network.architecture(), memory)?;
        Ok(self.graph.forward(network, batch, memory, &[])?.outputs()?)
    }

    /// One update of a training; gives the value of the loss before it.
    ///
    /// `loss(outputs, d_outputs)` returns the loss and fills the gradient, which enters as zeros, by the outputs,
    /// both laid out as [`Backprop::predict`] returns them. Back-propagation ends at the first step of the batch: the
    /// memory before it is a constant. `memory` goes on, also where the update fails.
    ///
    /// # Errors
    /// As [`Backprop::predict`] and [`Training::update`].
    pub fn update(
        &self,
        training: &mut Training<Network>,
        batch: &Batch<'_>,
        memory: &mut Memory,
        loss: impl FnOnce(&[f32], &mut [f32]) -> f64,
    ) -> Result<f64> {
        let steps = training.steps();
        let (value, gradients) = self.gradient(training.model(), steps, batch, memory, loss)?;
        training.update(value, &gradients)?;
        Ok(value)
    }

    /// The loss, and its gradient by each vector of parameters, as [`Backprop::update`] takes them; `step` says which dropout.
    ///
    /// # Errors
    /// As [`Backprop::predict`]; `NotFinite` for a loss that is not.
    pub(crate) fn gradient(
        &self,
        network: &Network,
        step: u64,
        batch: &Batch<'_>,
        memory: &mut Memory,
        loss: impl FnOnce(&[f32], &mut [f32]) -> f64,
    ) -> Result<(f64, Vec<Vec<f32>>)> {
        batch.check(network.architecture(), memory)?;
        let masks = self.masks(network.architecture(), batch, step);
        let pass = self.graph.forward(network, batch, memory, &masks)?;
        let outputs = pass.outputs()?;
        let mut d_outputs = vec![0.0; outputs.len()];
        let value = loss(&outputs, &mut d_outputs);
        if !value.is_finite() {
            return Err(Error::NotFinite { step, what: "loss", value });
        }
        Ok((value, pass.gradients(&d_outputs)?))
    }

    /// What the sequences between layers are multiplied by in this step: 0 or 1/(1 - p).
    fn masks(&self, architecture: &Architecture, batch: &Batch<'_>, step: u64) -> Vec<Vec<f32>> {
        let Architecture { hidden, layers, dropout, .. } = *architecture;
        if dropout == 0.0 {
            return Vec::new();
        }
        let kept = (1.0 / (1.0 - dropout)) as f32;
        let mut stream = rng(self.seed, &format!("learn/dropout/{step}"));
        let n = batch.steps * batch.rows * hidden;
        let mut draw = || if f64::from(stream.random::<f32>()) < dropout { 0.0 } else { kept };
        (1..layers).map(|_| (0..n).map(|_| draw()).collect()).collect()
    }
}
