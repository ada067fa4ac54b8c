//! How an inverse controller was trained, as its checkpoint holds it.

use std::path::PathBuf;

use hysteron_learn::{Provenance, WeightFormat, WindowOptions, options_of_this_version};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::recurrent_options::RecurrentOptions;
use super::{Candidate, DataOrigin, Dataset, Demonstration};

/// The training of an inverse controller: data, options, errors in validation.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct InverseTraining {
    /// The design.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub design: Option<TrainedDesign>,
    /// Which of the controllers that were compared it is; none where there was no comparison.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub candidate: Option<Candidate>,
    /// The twin that finds the strokes where it leads the tip closer than the network in validation.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub twin: Option<LeadingTwin>,
    /// Options; none where a program of another version wrote them.
    #[serde(deserialize_with = "options_of_this_version", skip_serializing_if = "Option::is_none")]
    pub options: Option<InverseOptions>,
    /// Training recordings.
    pub trained_on: Vec<TrainedOn>,
    /// Validation recordings.
    pub held_out: Vec<TrainedOn>,
    /// Folds that the errors in validation are of: it was then fitted to all recordings.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub folds: Option<usize>,
    /// Epochs after which the weights were found.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub epochs: Option<usize>,
    /// Root mean square error of each stroke in validation [mm].
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub held_out_stroke_rmse_mm: Vec<f64>,
    /// The same of the map that the network corrects, or of the static regression beside a network that has none [mm].
    #[serde(alias = "static_regression_stroke_rmse_mm", skip_serializing_if = "Vec::is_empty")]
    pub base_stroke_rmse_mm: Vec<f64>,
    /// Delay of the tip behind the strokes [s].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub delay_s: Option<f64>,
    /// Errors from the number format of the weights, where it is not that of the training.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub weights: Option<WeightErrors>,
    /// Error of the gradient that the floor of derivatives makes, over its length, of the published design [-].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gradient_floor_relative_error: Option<f64>,
    /// The command and the program that wrote the checkpoint.
    #[serde(flatten)]
    pub provenance: Option<Provenance>,
}

/// A twin that leads the tip closer than the network that learned from it; its files are named from the folder of the checkpoint.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct LeadingTwin {
    /// Its scene.
    pub scene: PathBuf,
    /// Hash of the scene and its mesh.
    pub scene_sha256: String,
    /// Its residual network.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub residual: Option<PathBuf>,
    /// SHA-256 of that file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub residual_sha256: Option<String>,
    /// Its error of the tip in validation, root mean square [mm].
    pub tip_rmse_mm: f64,
}

/// Which design was trained.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum TrainedDesign {
    /// Features of the path, one cell update a sample.
    #[serde(alias = "stateful")]
    Recurrent,
    /// The published one.
    Paper,
}

/// Options of a training.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum InverseOptions {
    /// Of the recurrent design.
    Recurrent(RecurrentOptions),
    /// Of the published design.
    Windowed(WindowOptions),
}

/// A recording of a training.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct TrainedOn {
    /// Its name.
    pub name: String,
    /// SHA-256 of its file.
    pub sha256: String,
    /// Where its strokes and tip come from.
    pub origin: DataOrigin,
}

/// Errors of the strokes in validation that the number format of the weights makes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct WeightErrors {
    /// The format.
    pub format: WeightFormat,
    /// Root mean square [mm].
    pub stroke_rmse_mm: f64,
    /// Largest [mm].
    pub stroke_largest_mm: f64,
}

impl InverseTraining {
    /// Design, options and data: what a file to resume from must have in common with a training.
    pub(super) fn of(design: TrainedDesign, options: InverseOptions, data: &Dataset) -> Self {
        let listed = |all: &[Demonstration]| all.iter().map(TrainedOn::of).collect();
        Self {
            design: Some(design),
            options: Some(options),
            trained_on: listed(&data.training),
            held_out: listed(&data.validation),
            ..Self::default()
        }
    }
}

impl TrainedOn {
    fn of(one: &Demonstration) -> Self {
        Self { name: one.name.clone(), sha256: one.hash.clone(), origin: one.origin }
    }
}
