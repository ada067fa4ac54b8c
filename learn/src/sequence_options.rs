//! How a network learns from whole sequences: pieces of them in order, with the memory handed on, one cell update a sample.

use hysteron_base::BadInput;
use serde::{Deserialize, Serialize};

use crate::schedule::{MOST_EPOCHS, MOST_HIDDEN, MOST_LAYERS, MOST_ROWS, check_counts};
use crate::{Adam, Architecture, Fall, Head, Schedule};

/// What trainings on whole sequences have in common.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SequenceOptions {
    /// Hidden units of each layer.
    pub hidden: usize,
    /// LSTM layers.
    pub layers: usize,
    /// Most epochs.
    pub epochs: usize,
    /// Epochs without a better held-out error after which it ends.
    pub patience: usize,
    /// Samples of a piece: back-propagation goes no further.
    pub piece: usize,
    /// Step size of Adam at the start; it falls to a hundredth along half a cosine.
    pub learning_rate: f64,
    /// Width of the uniform noise on normalised inputs while training, against learning sequences by heart.
    pub input_noise: f64,
    /// Part of the running mean of the weights that each step renews.
    pub renewed: f32,
}

impl SequenceOptions {
    /// The same with as many epochs and hidden units as are given.
    #[must_use]
    pub fn with(self, [epochs, hidden]: [Option<usize>; 2]) -> Self {
        Self { epochs: epochs.unwrap_or(self.epochs), hidden: hidden.unwrap_or(self.hidden), ..self }
    }

    /// Refuses options out of range.
    ///
    /// # Errors
    /// A number that no training can have.
    pub fn check(&self) -> Result<(), BadInput> {
        check_counts(&[
            ("epochs", self.epochs, MOST_EPOCHS),
            ("patience", self.patience, MOST_EPOCHS),
            ("piece", self.piece, MOST_ROWS),
            ("hidden", self.hidden, MOST_HIDDEN),
            ("layers", self.layers, MOST_LAYERS),
        ])?;
        let noise = self.input_noise;
        if !(noise >= 0.0 && noise.is_finite()) {
            return Err(BadInput::new("input_noise", "a finite number >= 0", noise.to_string()));
        }
        if !(self.renewed > 0.0 && self.renewed <= 1.0) {
            return Err(BadInput::new("renewed", "0 < part <= 1", self.renewed.to_string()));
        }
        Ok(())
    }

    /// The network for so many inputs and outputs.
    pub fn architecture(&self, inputs: usize, outputs: usize) -> Architecture {
        let Self { hidden, layers, .. } = *self;
        Architecture { inputs, hidden, layers, outputs, head: Head::Linear, dropout: 0.0 }
    }

    /// The course of the training; gradients are no longer than 1.
    pub fn schedule(&self) -> Schedule {
        let Self { epochs, patience, learning_rate, renewed, .. } = *self;
        Schedule {
            epochs,
            patience,
            adam: Adam { learning_rate, clip_norm: Some(1.0), ..Adam::default() },
            fall: Fall::HalfCosine,
            renewed: Some(renewed),
            gradient_floor: 0.0,
        }
    }
}
