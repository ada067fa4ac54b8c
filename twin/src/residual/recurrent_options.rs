//! How the recurrent residual network is trained.

use hysteron_learn::SequenceOptions;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How to train.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "ResidualRecurrentOptions")]
pub struct RecurrentOptions {
    /// Options common to trainings on whole trajectories.
    #[serde(flatten)]
    pub learning: SequenceOptions,
    /// Plays as parts of the largest stroke.
    pub plays: Vec<f64>,
    /// Time constants of first-order filters [s].
    pub filters_s: Vec<f64>,
    /// Whether the twin's tip is an input of the network.
    pub feedback: bool,
    /// Standard deviation of the noise on that tip while training [m], so that errors of the loop decay.
    pub feedback_noise_m: f64,
    /// Seed of weights and noise.
    pub seed: u64,
}

impl Default for RecurrentOptions {
    fn default() -> Self {
        Self {
            learning: SequenceOptions {
                hidden: 64,
                layers: 1,
                epochs: 100,
                patience: 40,
                ends_after: None,
                truncation: 200,
                learning_rate: 2e-3,
                input_noise: 1.0,
                // The average reaches back over some epochs.
                ema: 0.005,
            },
            plays: vec![0.01, 0.03, 0.08, 0.2, 0.5],
            filters_s: vec![0.3, 3.0, 30.0],
            feedback: false,
            feedback_noise_m: 2e-4,
            seed: 1,
        }
    }
}
