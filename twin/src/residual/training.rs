//! How a residual network was trained, as its checkpoint holds it.

use hysteron_learn::{Provenance, WindowOptions, mean, options_of_this_version};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::adapted_parts::AdaptedParts;
use super::band::TipBand;
use super::kept_parts::ResidualPart;
use super::recurrent_options::RecurrentOptions;

/// The training of a residual network: data, options, errors in validation, later adaptation.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct ResidualTraining {
    /// Options; none where a program of another version wrote them.
    #[serde(deserialize_with = "options_of_this_version", skip_serializing_if = "Option::is_none")]
    pub options: Option<ResidualOptions>,
    /// Names of all recordings, of the recurrent design.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub sequences: Vec<String>,
    /// One entry per network, of the recurrent design.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub members: Vec<TrainedMember>,
    /// The part that gains in validation, of the recurrent design; none in files of older programs, which hold the network.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub part: Option<ResidualPart>,
    /// Networks that learned from all recordings, for as many epochs as `members` took in the mean, whose errors are those of
    /// validation; none where the networks are `members` themselves.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub networks_of_all: Option<usize>,
    /// How far the tip may be off, by the recordings that were left out, of the recurrent design; none once it is adapted.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tip_band: Option<TipBand>,
    /// Hash of the scene, of the published design.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scene: Option<String>,
    /// Names of the training recordings, of the published design.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub trained_on: Vec<String>,
    /// Names of the validation recordings, of the published design.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub held_out: Vec<String>,
    /// SHA-256 of the training recordings and then of the validation recordings, of the published design.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub data_sha256: Vec<String>,
    /// Error of the gradient that the floor of derivatives makes, over its length, of the published design [-].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gradient_floor_relative_error: Option<f64>,
    /// Root mean square error of the auxiliary strokes in validation, of the published design [mm].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub held_out_stroke_rmse_mm: Option<f64>,
    /// Epochs after which the weights were found, of the published design.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub epochs: Option<usize>,
    /// Names and SHA-256 of the recordings that the network was adapted to.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub adapted_to: Vec<(String, String)>,
    /// Parts of the adaptation that were kept.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub adapted_kept: Option<AdaptedParts>,
    /// The command and the program that wrote the checkpoint.
    #[serde(flatten)]
    pub provenance: Option<Provenance>,
}

impl ResidualTraining {
    /// Error of the tip on recordings that the networks in the mean did not learn from, root mean square [mm]; none of the
    /// published design.
    pub fn validation_error_mm(&self) -> Option<f64> {
        let kept = self.members.iter().filter(|member| member.is_kept);
        let squares: Vec<f64> = kept.map(|member| member.held_out_rmse_mm.powi(2)).collect();
        (!squares.is_empty()).then(|| mean(&squares).sqrt())
    }
}

/// Options of a training.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum ResidualOptions {
    /// Of the recurrent design.
    Recurrent(RecurrentOptions),
    /// Of the published design.
    Windowed(WindowOptions),
}

/// The training of one of several networks whose mean is taken.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct TrainedMember {
    /// Names of its validation recordings.
    pub held_out: Vec<String>,
    /// Root mean square error of the tip in validation [mm].
    pub held_out_rmse_mm: f64,
    /// Epochs after which its weights were found.
    pub epochs: usize,
    /// Whether it is in the mean: false where it does no better in validation than the twin alone.
    #[serde(default = "is_kept")]
    pub is_kept: bool,
}

/// Every network of an older program is in the mean.
fn is_kept() -> bool {
    true
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test may stop where it stands
    use hysteron_base::json;

    use super::*;

    #[test]
    fn a_training_reads_back_and_options_of_another_version_are_left_out() {
        let provenance = Provenance { command: "hysteron".into(), commit: "0".into(), version: "1".into() };
        let member =
            TrainedMember { held_out: vec!["a".into()], held_out_rmse_mm: 0.5, epochs: 3, is_kept: true };
        let training = ResidualTraining {
            options: Some(ResidualOptions::Recurrent(RecurrentOptions::default())),
            members: vec![member],
            adapted_kept: Some(AdaptedParts::Change),
            provenance: Some(provenance),
            ..ResidualTraining::default()
        };
        let text = json::to_text(&training).unwrap();
        assert_eq!(json::from_text::<ResidualTraining>(&text).unwrap(), training);
        let older = text.replace("truncation", "piece");
        let read = json::from_text::<ResidualTraining>(older).unwrap();
        assert_eq!(read, ResidualTraining { options: None, ..training });
    }
}
