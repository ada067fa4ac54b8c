//! A network in training by hand, batch by batch; [`crate::fit`] trains by epochs.

use std::path::Path;

use hysteron_base::json;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use super::backprop::Backprop;
use crate::{Adam, Memory, Network, Result, SequenceBatch, Training};

/// A network, its optimiser and its passes.
#[derive(Debug)]
pub struct Trainer {
    training: Training<Network>,
    passes: Backprop,
}

/// Details of a training that a [`Trainer`] writes.
#[derive(Deserialize)]
struct TrainerDetails<D> {
    dropout_seed: u64,
    details: D,
}

impl Trainer {
    /// Training from these weights on; `seed` is for dropout.
    ///
    /// # Errors
    /// `BadInput` for a setting of `adam` out of its range; `Tensors` if a card refuses.
    pub fn new(network: Network, adam: Adam, seed: u64) -> Result<Self> {
        let passes = Backprop::new(network.architecture(), seed)?;
        Ok(Self { training: Training::new(network, adam, None)?, passes })
    }

    /// As [`Trainer::new`], see [`Backprop::unrolled`].
    ///
    /// # Errors
    /// `BadInput` for a setting of `adam` out of its range.
    pub fn unrolled(network: Network, adam: Adam, seed: u64) -> Result<Self> {
        let passes = Backprop::unrolled(network.architecture(), seed);
        Ok(Self { training: Training::new(network, adam, None)?, passes })
    }

    /// The network as it is now.
    pub fn network(&self) -> &Network {
        self.training.model()
    }

    /// See [`Training::set_learning_rate`].
    pub fn set_learning_rate(&mut self, learning_rate: f64) {
        self.training.set_learning_rate(learning_rate);
    }

    /// See [`Backprop::predict`].
    ///
    /// # Errors
    /// As there.
    pub fn predict(&self, batch: &SequenceBatch<'_>, memory: &mut Memory) -> Result<Vec<f32>> {
        self.passes.predict(self.network(), batch, memory)
    }

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
        self.passes.update(&mut self.training, batch, memory, loss)
    }

    /// Writes everything needed to resume, with the caller's `details`.
    ///
    /// # Errors
    /// `File` if the file system refuses.
    pub fn save(&self, path: &Path, details: &impl Serialize) -> Result<()> {
        self.training.save(path, &json!({ "dropout_seed": self.passes.seed(), "details": details }))
    }

    /// Goes on from a file by [`Trainer::save`] of a network of the architecture of `like`: the next steps are bit for bit those
    /// of the trainer that wrote it, on the same machine. Also gives the caller's details.
    ///
    /// # Errors
    /// `BadInput` for a file that is not whole, not by [`Trainer::save`] or of another version or architecture.
    pub fn load<D: DeserializeOwned>(path: &Path, like: &Network) -> Result<(Self, D)> {
        let (training, TrainerDetails { dropout_seed, details }) = Training::load(path, like)?;
        let passes = Backprop::new(like.architecture(), dropout_seed)?;
        Ok((Self { training, passes }, details))
    }
}
