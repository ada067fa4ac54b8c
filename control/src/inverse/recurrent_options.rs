//! How the recurrent inverse network is trained.

use hysteron_learn::{SequenceOptions, WeightFormat};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::loss::LossWeights;
use super::path_point::PathSmoothing;

/// A map from the path to strokes; a network may correct it.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum BaseMap {
    /// Cubic polynomials of the tip some time later.
    #[default]
    Cubic,
    /// The same, and kernel regression on features of the path for what they leave.
    Kernel,
}

/// How to train.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "InverseRecurrentOptions")]
pub struct RecurrentOptions {
    /// Options common to trainings on whole trajectories.
    #[serde(flatten)]
    pub learning: SequenceOptions,
    /// Which samples positions and rates come from.
    pub smoothing: PathSmoothing,
    /// Half the time that they span [s].
    pub half_width_s: f64,
    /// Times ahead at which features of the path are taken [s]; with [`PathSmoothing::Causal`] and none, a path
    /// need not be known in advance.
    pub horizons_s: Vec<f64>,
    /// Speed at which the direction counts about half [m/s].
    pub slow_m_s: f64,
    /// Plays as parts of the largest stroke.
    pub plays: Vec<f64>,
    /// Time constants of first-order filters [s].
    pub filters_s: Vec<f64>,
    /// The map that the network corrects.
    #[serde(default)]
    pub base: BaseMap,
    /// Weights of the terms of the loss.
    pub loss: LossWeights,
    /// Largest delay of the tip behind its strokes that is sought [s]; none is where it is zero, as for a path that
    /// is not known in advance.
    pub largest_delay_s: f64,
    /// Number format of the weights where the controller commands.
    pub weights: WeightFormat,
    /// Seed of weights and noise.
    pub seed: u64,
}

/// Updates of the weights that a training has at least: their moving average forgets where it began within a few hundred.
const MIN_UPDATES: usize = 1000;

impl RecurrentOptions {
    /// Epochs for demonstrations of which the longest has so many samples: those of the options, or as many as make enough updates
    /// of the weights.
    pub fn epochs_for(&self, longest: usize) -> usize {
        let updates = longest.div_ceil(self.learning.truncation.max(1)).max(1);
        self.learning.epochs.max(MIN_UPDATES.div_ceil(updates))
    }
}

impl Default for RecurrentOptions {
    fn default() -> Self {
        Self {
            learning: SequenceOptions {
                hidden: 128,
                layers: 1,
                epochs: 30,
                patience: 40,
                ends_after: None,
                truncation: 200,
                learning_rate: 2e-3,
                input_noise: 0.3,
                ema: 0.005,
            },
            smoothing: PathSmoothing::Centred,
            half_width_s: 0.1,
            horizons_s: vec![0.1, 0.2, 0.4],
            slow_m_s: 1e-3,
            plays: vec![0.02, 0.05, 0.12, 0.3, 0.6],
            filters_s: vec![0.3, 3.0, 30.0],
            base: BaseMap::Cubic,
            loss: LossWeights { tip: 1.0, smooth_s: 0.1, pull: 1.0, co_contraction_min_m: 0.0 },
            largest_delay_s: 0.5,
            weights: WeightFormat::Float32,
            seed: 1,
        }
    }
}
