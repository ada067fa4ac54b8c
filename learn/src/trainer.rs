//! Training: forward, loss, back through time, Adam; and a file from which it goes on bit for bit.

use std::path::Path;

use hysteron_base::{BadInput, rng};
use rand::RngExt;
use serde_json::{Value, json};

use crate::adam::Moments;
use crate::graph::Graph;
use crate::tensor_file::TensorFile;
use crate::{Adam, Architecture, Batch, Error, Memory, Network, Result};

pub(crate) const FORMAT: &str = "hysteron-training";
pub(crate) const VERSION: u64 = 1;

/// A network in training.
#[derive(Debug)]
pub struct Trainer {
    network: Network,
    adam: Adam,
    seed: u64,
    /// Steps done.
    steps: u64,
    /// For each vector of parameters.
    moments: Vec<Moments<f32>>,
    graph: Graph,
}

impl Trainer {
    /// Training from these weights on; `seed` is for dropout. Runs on the processor, or with the feature `cuda`
    /// on the first NVIDIA card there is.
    ///
    /// # Errors
    /// `BadInput` for a setting of `adam` out of its range; `Tensors` if a card refuses.
    pub fn new(network: Network, adam: Adam, seed: u64) -> Result<Self> {
        let graph = Graph::new(network.architecture())?;
        Self::with_graph(network, adam, seed, graph)
    }

    /// As [`Trainer::new`], with candle's own cells on the processor: what other devices do, many times slower
    /// here. The fused layers are measured and checked against it.
    ///
    /// # Errors
    /// As [`Trainer::new`].
    pub fn unrolled(network: Network, adam: Adam, seed: u64) -> Result<Self> {
        let graph = Graph::unrolled(network.architecture());
        Self::with_graph(network, adam, seed, graph)
    }

    fn with_graph(network: Network, adam: Adam, seed: u64, graph: Graph) -> Result<Self> {
        adam.check()?;
        let moments = network.parameters.iter().map(|values| Moments::zeros(values.len())).collect();
        Ok(Self { network, adam, seed, steps: 0, moments, graph })
    }

    /// The network as it is now.
    pub fn network(&self) -> &Network {
        &self.network
    }

    /// The network, without what only training needs.
    pub fn into_network(self) -> Network {
        self.network
    }

    /// The step size from the next step on; negative or not finite values are refused by that step.
    pub fn set_learning_rate(&mut self, learning_rate: f64) {
        self.adam.learning_rate = learning_rate;
    }

    /// Derivatives of at most this size become zero from the next step on, see [`crate::Schedule::gradient_floor`]; none do
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
    pub fn predict(&self, batch: &Batch<'_>, memory: &mut Memory) -> Result<Vec<f32>> {
        self.predict_with(&self.network, batch, memory)
    }

    /// As [`Trainer::predict`], with other weights of the same shape.
    pub(crate) fn predict_with(
        &self,
        network: &Network,
        batch: &Batch<'_>,
        memory: &mut Memory,
    ) -> Result<Vec<f32>> {
        batch.check(network.architecture(), memory)?;
        Ok(self.graph.forward(network, batch, memory, &[])?.outputs()?)
    }

    /// One step of training; gives the value of the loss before it.
    ///
    /// `loss(outputs, d_outputs)` returns the loss and fills the gradient, which enters as zeros, by the outputs,
    /// both laid out as [`Trainer::predict`] returns them. Going back ends at the first step of the batch: the
    /// memory before it is a constant. `memory` goes on, also where the step fails.
    ///
    /// # Errors
    /// As [`Trainer::predict`]; `NotFinite` if the loss or the gradient is not finite. Weights are then as before.
    pub fn step(
        &mut self,
        batch: &Batch<'_>,
        memory: &mut Memory,
        loss: impl FnOnce(&[f32], &mut [f32]) -> f64,
    ) -> Result<f64> {
        self.adam.check()?;
        let (value, gradients) = self.gradient(batch, memory, loss)?;
        let square = |values: &Vec<f32>| values.iter().map(|v| f64::from(*v).powi(2)).sum::<f64>();
        let norm = gradients.iter().map(square).sum::<f64>().sqrt();
        self.finite("norm of the gradient", norm)?;
        self.steps += 1;
        let scale = self.adam.scale(norm);
        let parameters = self.network.parameters.iter_mut().zip(&mut self.moments);
        for ((weights, moments), gradient) in parameters.zip(&gradients) {
            self.adam.update(self.steps, scale, gradient, weights, moments);
        }
        Ok(value)
    }

    /// The loss, and its gradient by each vector of parameters, as [`Trainer::step`] takes them.
    ///
    /// # Errors
    /// As [`Trainer::step`].
    pub(crate) fn gradient(
        &self,
        batch: &Batch<'_>,
        memory: &mut Memory,
        loss: impl FnOnce(&[f32], &mut [f32]) -> f64,
    ) -> Result<(f64, Vec<Vec<f32>>)> {
        batch.check(self.network.architecture(), memory)?;
        let masks = self.masks(batch);
        let pass = self.graph.forward(&self.network, batch, memory, &masks)?;
        let outputs = pass.outputs()?;
        let mut d_outputs = vec![0.0; outputs.len()];
        let value = loss(&outputs, &mut d_outputs);
        self.finite("loss", value)?;
        Ok((value, pass.gradients(&d_outputs)?))
    }

    fn finite(&self, what: &'static str, value: f64) -> Result<()> {
        if value.is_finite() { Ok(()) } else { Err(Error::NotFinite { step: self.steps, what, value }) }
    }

    /// What the sequences between layers are multiplied by in this step: 0 or 1/(1 - p).
    fn masks(&self, batch: &Batch<'_>) -> Vec<Vec<f32>> {
        let Architecture { hidden, layers, dropout, .. } = *self.network.architecture();
        if dropout == 0.0 {
            return Vec::new();
        }
        let kept = (1.0 / (1.0 - dropout)) as f32;
        let mut stream = rng(self.seed, &format!("learn/dropout/{}", self.steps));
        let n = batch.steps * batch.rows * hidden;
        let mut draw = || if f64::from(stream.random::<f32>()) < dropout { 0.0 } else { kept };
        (1..layers).map(|_| (0..n).map(|_| draw()).collect()).collect()
    }

    /// Writes everything needed to go on, with what the caller wants to find beside it.
    ///
    /// # Errors
    /// `File` if the file system refuses.
    pub fn save(&self, path: &Path, details: &Value) -> Result<()> {
        let mut file = TensorFile::default();
        file.put("details", details.clone());
        self.put_into(&mut file);
        file.write(path, FORMAT, VERSION)
    }

    /// Everything needed to go on.
    pub(crate) fn put_into(&self, file: &mut TensorFile) {
        file.put("architecture", json!(self.network.architecture()));
        file.put("adam", json!(self.adam));
        file.put("dropout", json!({ "seed": self.seed, "steps": self.steps }));
        file.put_network("", self.network.architecture(), &self.network.parameters);
        let [mean, square]: [Vec<Vec<f32>>; 2] = [
            self.moments.iter().map(|m| m.mean.clone()).collect(),
            self.moments.iter().map(|m| m.square.clone()).collect(),
        ];
        file.put_network("adam.mean.", self.network.architecture(), &mean);
        file.put_network("adam.square.", self.network.architecture(), &square);
    }

    /// Goes on from a file by [`Trainer::save`]: the next steps are bit for bit those of the trainer that wrote
    /// it, on the same machine. Also gives the caller's details.
    ///
    /// # Errors
    /// `BadInput` for a file that is not whole, not by [`Trainer::save`] or of another version.
    pub fn load(path: &Path) -> Result<(Self, Value)> {
        let within = |bad: BadInput| bad.within(path.display());
        let mut file = TensorFile::read(path, FORMAT, VERSION)?;
        let details = file.take("details").map_err(within)?;
        Ok((Self::take_from(&mut file).map_err(|error| error.within(path.display()))?, details))
    }

    /// The inverse of [`Trainer::put_into`].
    pub(crate) fn take_from(file: &mut TensorFile) -> Result<Self> {
        let architecture: Architecture = file.take("architecture")?;
        let adam: Adam = file.take("adam")?;
        let Dropout { seed, steps } = file.take("dropout")?;
        let mut parameters = |prefix| file.take_network(prefix, &architecture);
        let network = Network::from_parameters(architecture.clone(), parameters("")?)?;
        let moments = parameters("adam.mean.")?.into_iter().zip(parameters("adam.square.")?);
        let moments = moments.map(|(mean, square)| Moments { mean, square }).collect();
        let trainer = Self::new(network, adam, seed)?;
        Ok(Self { steps, moments, ..trainer })
    }
}

/// Where the streams of dropout stand.
#[derive(serde::Deserialize)]
struct Dropout {
    seed: u64,
    steps: u64,
}
