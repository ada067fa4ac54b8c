//! How a network learns from whole sequences.

use hysteron_base::BadInput;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::engine::{MAX_EPOCHS, MAX_HIDDEN, MAX_LAYERS, MAX_ROWS, check_counts};
use crate::{Adam, Architecture, Decay, HeadActivation, Schedule};

/// Options common to trainings on whole sequences; one cell update a sample.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SequenceOptions {
    /// Hidden units of each layer.
    pub hidden: usize,
    /// LSTM layers.
    pub layers: usize,
    /// Most epochs.
    pub epochs: usize,
    /// Epochs without a better validation error after which it ends.
    pub patience: usize,
    /// Epochs after which it ends, without validation data; none where validation chooses.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ends_after: Option<usize>,
    /// Truncation length: samples between two updates, and of back-propagation through time.
    pub truncation: usize,
    /// Step size of Adam at the start; it decays to a hundredth along half a cosine.
    pub learning_rate: f64,
    /// Width of the uniform noise on normalised inputs while training, against overfitting.
    pub input_noise: f64,
    /// Part of the exponential moving average of the weights that each update replaces.
    pub ema: f32,
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
            ("epochs", self.epochs, MAX_EPOCHS),
            ("patience", self.patience, MAX_EPOCHS),
            ("truncation", self.truncation, MAX_ROWS),
            ("hidden", self.hidden, MAX_HIDDEN),
            ("layers", self.layers, MAX_LAYERS),
        ])?;
        let noise = self.input_noise;
        if !(noise >= 0.0 && noise.is_finite()) {
            return Err(BadInput::new("input_noise", "a finite number >= 0", noise.to_string()));
        }
        if !(self.ema > 0.0 && self.ema <= 1.0) {
            return Err(BadInput::new("ema", "0 < part <= 1", self.ema.to_string()));
        }
        Ok(())
    }

    /// The network for so many inputs and outputs.
    pub fn architecture(&self, inputs: usize, outputs: usize) -> Architecture {
        let Self { hidden, layers, .. } = *self;
        Architecture { inputs, hidden, layers, outputs, head: HeadActivation::Linear, dropout: 0.0 }
    }

    /// Epochs and step sizes; gradients are no longer than 1.
    pub fn schedule(&self) -> Schedule {
        let Self { epochs, patience, learning_rate, ema, .. } = *self;
        Schedule {
            epochs,
            patience,
            adam: Adam { learning_rate, clip_norm: Some(1.0), ..Adam::default() },
            decay: Decay::Cosine,
            ema: Some(ema),
        }
    }
}
