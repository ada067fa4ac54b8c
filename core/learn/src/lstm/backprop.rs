//! Passes of an LSTM network over batches: outputs, and the gradient of a loss by back-propagation through time.

use hysteron_base::rng;
use rand::RngExt;

use super::graph::Graph;
use crate::on_device::{DeviceGradients, DeviceWeights, OnDevice};
use crate::{Architecture, Error, Memory, Network, Result, SequenceBatch, TrainableModel, Training};

/// Graph and scratch of passes of networks of one architecture, reused from batch to batch. Runs on the
/// processor, or with the feature `cuda` on the first NVIDIA card there is.
#[derive(Debug)]
pub struct Backprop {
    graph: Graph,
    /// Of dropout.
    seed: u64,
    home: Home,
}

/// Where weights and the optimiser's state are while updates are made.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Home {
    /// In plain arrays; every pass takes them to where it is computed.
    Host,
    /// Where passes are computed.
    Device,
}

impl Backprop {
    /// Passes of networks of this architecture; `seed` is for dropout.
    ///
    /// # Errors
    /// `Tensors` if a card refuses.
    pub fn new(architecture: &Architecture, seed: u64) -> Result<Self> {
        let graph = Graph::new(architecture)?;
        let home = if graph.is_on_card() { Home::Device } else { Home::Host };
        Ok(Self { graph, seed, home })
    }

    /// As [`Backprop::new`], with candle's own cells on the processor, many times slower: what layers are measured and checked against.
    pub fn unrolled(architecture: &Architecture, seed: u64) -> Self {
        Self { graph: Graph::unrolled(architecture), seed, home: Home::Host }
    }

    /// Passes by the operations used on a card, computed on the processor.
    #[cfg(test)]
    pub(super) fn as_on_card(architecture: &Architecture, seed: u64) -> Self {
        Self { graph: Graph::as_on_card(architecture), seed, home: Home::Device }
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
    /// [`crate::HeadOutputs::Last`]. `memory` is carried over.
    ///
    /// # Errors
    /// `BadInput` if batch or memory do not fit the network or an input is not finite.
    pub fn predict(
        &self,
        network: &Network,
        batch: &SequenceBatch<'_>,
        memory: &mut Memory,
    ) -> Result<Vec<f32>> {
        self.place(network)?.predict(batch, memory)
    }

    /// A network for the predictions of many batches; its weights are taken to a card once.
    ///
    /// # Errors
    /// `Tensors` if a card refuses.
    pub fn place<'a>(&'a self, network: &'a Network) -> Result<PlacedNetwork<'a>> {
        let weights = self.weights(network)?;
        Ok(PlacedNetwork { graph: &self.graph, architecture: network.architecture(), weights })
    }

    fn weights(&self, network: &Network) -> Result<DeviceWeights> {
        Ok(DeviceWeights::new(self.graph.device(), network.parameters())?)
    }

    /// For many updates of a training; on a card, weights, moments and moving average stay there until [`Updates::finish`].
    ///
    /// # Errors
    /// `Tensors` if a card refuses.
    pub fn updates<'a>(&'a self, training: &'a mut Training<Network>) -> Result<Updates<'a>> {
        let on_device = match self.home {
            Home::Host => None,
            Home::Device => Some(OnDevice::new(self.graph.device(), training)?),
        };
        Ok(Updates { passes: self, training, on_device })
    }

    /// One update of a training; gives the value of the loss before it.
    ///
    /// `loss(outputs, d_outputs)` returns the loss and fills the gradient, which enters as zeros, by the outputs,
    /// both laid out as [`Backprop::predict`] returns them. Back-propagation ends at the first step of the batch: the
    /// memory before it is a constant. `memory` is carried over, also where the update fails.
    ///
    /// # Errors
    /// As [`Backprop::predict`] and [`Training::update`].
    pub fn update(
        &self,
        training: &mut Training<Network>,
        batch: &SequenceBatch<'_>,
        memory: &mut Memory,
        loss: impl FnOnce(&[f32], &mut [f32]) -> f64,
    ) -> Result<f64> {
        let mut updates = self.updates(training)?;
        let value = updates.step(batch, memory, loss)?;
        updates.finish()?;
        Ok(value)
    }

    /// The loss, and its gradient by each vector of parameters, as [`Backprop::update`] takes them; `step` selects the dropout mask.
    ///
    /// # Errors
    /// As [`Backprop::predict`]; `NotFinite` for a loss that is not.
    pub(crate) fn gradient(
        &self,
        network: &Network,
        step: u64,
        batch: &SequenceBatch<'_>,
        memory: &mut Memory,
        loss: impl FnOnce(&[f32], &mut [f32]) -> f64,
    ) -> Result<(f64, Vec<Vec<f32>>)> {
        let weights = self.weights(network)?;
        let of = (network.architecture(), &weights);
        let (value, gradients) = self.gradient_at(of, step, batch, memory, loss)?;
        Ok((value, gradients.to_vecs()?))
    }

    /// As [`Self::gradient`], where passes are computed.
    fn gradient_at(
        &self,
        (architecture, weights): (&Architecture, &DeviceWeights),
        step: u64,
        batch: &SequenceBatch<'_>,
        memory: &mut Memory,
        loss: impl FnOnce(&[f32], &mut [f32]) -> f64,
    ) -> Result<(f64, DeviceGradients)> {
        batch.check(architecture, memory)?;
        let masks = self.masks(architecture, batch, step);
        let pass = self.graph.forward((architecture, weights), batch, memory, &masks)?;
        let outputs = pass.outputs()?;
        let mut d_outputs = vec![0.0; outputs.len()];
        let value = loss(&outputs, &mut d_outputs);
        if !value.is_finite() {
            return Err(Error::NotFinite { step, what: "loss", value });
        }
        Ok((value, pass.gradients(weights, &d_outputs)?))
    }

    /// Dropout factors on the sequences between layers in this step: 0 or 1/(1 - p); (layers - 1) × (steps ·
    /// rows · hidden).
    fn masks(&self, architecture: &Architecture, batch: &SequenceBatch<'_>, step: u64) -> Vec<Vec<f32>> {
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

/// A network whose weights are where passes are computed.
#[derive(Debug)]
pub struct PlacedNetwork<'a> {
    graph: &'a Graph,
    architecture: &'a Architecture,
    weights: DeviceWeights,
}

impl PlacedNetwork<'_> {
    /// See [`Backprop::predict`].
    ///
    /// # Errors
    /// As there.
    pub fn predict(&self, batch: &SequenceBatch<'_>, memory: &mut Memory) -> Result<Vec<f32>> {
        batch.check(self.architecture, memory)?;
        Ok(self.graph.forward((self.architecture, &self.weights), batch, memory, &[])?.outputs()?)
    }
}

/// Updates of a training, one after the other. Those on a card are the training's once they are finished, and lost otherwise.
#[derive(Debug)]
pub struct Updates<'a> {
    passes: &'a Backprop,
    training: &'a mut Training<Network>,
    on_device: Option<OnDevice>,
}

impl Updates<'_> {
    /// See [`Backprop::update`].
    ///
    /// # Errors
    /// As there.
    pub fn step(
        &mut self,
        batch: &SequenceBatch<'_>,
        memory: &mut Memory,
        loss: impl FnOnce(&[f32], &mut [f32]) -> f64,
    ) -> Result<f64> {
        let Self { passes, training, on_device } = self;
        let network = training.model();
        match on_device {
            None => {
                let (value, gradients) = passes.gradient(network, training.steps(), batch, memory, loss)?;
                training.update(value, &gradients)?;
                Ok(value)
            }
            Some(own) => {
                let of = (network.architecture(), own.weights());
                let (value, gradients) = passes.gradient_at(of, own.steps(), batch, memory, loss)?;
                own.update(training, value, &gradients)?;
                Ok(value)
            }
        }
    }

    /// Hands what the updates have come to over to the training.
    ///
    /// # Errors
    /// `Tensors` if a card refuses.
    pub fn finish(self) -> Result<()> {
        match self.on_device {
            None => Ok(()),
            Some(own) => own.finish(self.training),
        }
    }

    #[cfg(test)]
    pub(super) fn on_device(&self) -> Option<&OnDevice> {
        self.on_device.as_ref()
    }

    #[cfg(test)]
    pub(super) fn training(&self) -> &Training<Network> {
        self.training
    }
}
