//! A trained residual network with everything a rollout needs.

use std::path::Path;

use hysteron_base::BadInput;
use hysteron_learn::{Checkpoint, Network, Normaliser};
use serde::{Deserialize, Serialize};

use super::linear::one_or_more;
use super::{Adaptation, FeatureSpec, LinearPart, ResidualTraining, RobotChange, StrokeDecoder};
use crate::Result;

/// How network and twin go together.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ResidualDesign {
    /// The paper's: a sliding window of strokes and tips (eq. 9).
    Windowed {
        /// Samples of a window.
        window: usize,
    },
    /// One cell update a sample.
    #[serde(alias = "stateful")]
    Recurrent {
        /// Inputs of the network.
        features: FeatureSpec,
        /// Decoder of its outputs.
        decoder: StrokeDecoder,
        /// Linear part of the outputs: the mean of these, one for each network that the mean of networks is
        /// made of.
        #[serde(deserialize_with = "one_or_more")]
        linear: Vec<LinearPart>,
    },
}

/// The residual network g.
#[derive(Debug, Clone, PartialEq)]
pub struct ResidualModel {
    /// Weights.
    pub network: Network,
    /// Channels that enter.
    pub inputs: Normaliser,
    /// Channels that leave.
    pub outputs: Normaliser,
    /// How they are made and used.
    pub design: ResidualDesign,
    /// Auxiliary tendons that it drives.
    pub n_aux: usize,
    /// Duration of a sample [s].
    pub step_s: f64,
    /// Hash of the scene that it was trained for.
    pub scene_hash: String,
    /// Change of the robot since, as far as a few physical numbers describe it.
    pub change: Option<RobotChange>,
    /// Linear correction fitted to the robot since.
    pub adaptation: Option<Adaptation>,
    /// Data, options, scores, later adaptation.
    pub training: ResidualTraining,
}

const KIND: &str = "residual";

/// Metadata of a checkpoint, next to the network.
#[derive(Serialize, Deserialize)]
struct ResidualDetails {
    design: ResidualDesign,
    n_aux: usize,
    step_s: f64,
    scene_sha256: String,
    #[serde(default)]
    change: Option<RobotChange>,
    #[serde(default)]
    adaptation: Option<Adaptation>,
    #[serde(default)]
    training: Option<ResidualTraining>,
}

/// Most tendons or samples of a window that are accepted, so that products of sizes cannot overflow.
const MAX_SIZE: usize = 1 << 16;

/// Largest difference of a sample's duration from that of the training.
const SAME_STEP: f64 = 0.01;

impl ResidualModel {
    /// Writes a checkpoint.
    ///
    /// # Errors
    /// Refusals of the file system.
    pub fn write(&self, path: &Path) -> Result<()> {
        let details = ResidualDetails {
            design: self.design.clone(),
            n_aux: self.n_aux,
            step_s: self.step_s,
            scene_sha256: self.scene_hash.clone(),
            change: self.change.clone(),
            adaptation: self.adaptation.clone(),
            training: Some(self.training.clone()),
        };
        let (network, inputs, outputs) = (self.network.clone(), self.inputs.clone(), self.outputs.clone());
        Checkpoint { kind: KIND.into(), network, inputs, outputs, details }.write(path)?;
        Ok(())
    }

    /// Reads a checkpoint.
    ///
    /// # Errors
    /// Not a checkpoint, not of a residual network, damaged, or of parts that do not fit each other.
    pub fn read(path: &Path) -> Result<Self> {
        let found: Checkpoint<ResidualDetails> = Checkpoint::read(path, KIND)?;
        let Checkpoint { network, inputs, outputs, details, .. } = found;
        let model = Self {
            design: details.design,
            change: details.change,
            adaptation: details.adaptation,
            n_aux: details.n_aux,
            step_s: details.step_s,
            scene_hash: details.scene_sha256,
            training: details.training.unwrap_or_default(),
            network,
            inputs,
            outputs,
        };
        model.check_parts().map_err(|bad| bad.within(path.display()))?;
        Ok(model)
    }

    /// That the parts fit each other.
    fn check_parts(&self) -> std::result::Result<(), BadInput> {
        let (n_in, n_out) = (self.inputs.channels.len(), self.outputs.channels.len());
        let sizes = match &self.design {
            ResidualDesign::Recurrent { features, .. } => vec![("n_primary", features.n_primary)],
            ResidualDesign::Windowed { window } => vec![("window", *window)],
        };
        for (part, size) in [("n_aux", self.n_aux)].into_iter().chain(sizes) {
            if !(1..=MAX_SIZE).contains(&size) {
                return Err(BadInput::new(part, format!("1 to {MAX_SIZE}"), size.to_string()));
            }
        }
        let channels = |expected: String| {
            Err(BadInput::new("channels", expected, format!("{n_in} inputs and {n_out} outputs")))
        };
        let parts = match &self.design {
            ResidualDesign::Windowed { .. } if n_in <= 3 || n_out != self.n_aux => {
                return channels(format!("strokes and 3 axes of the tip in, {} strokes out", self.n_aux));
            }
            ResidualDesign::Windowed { .. } => [true, true, true, self.adaptation.is_none()],
            ResidualDesign::Recurrent { features, .. } if (n_in, n_out) != (features.len(), 3) => {
                return channels(format!("{} inputs and 3 outputs", features.len()));
            }
            ResidualDesign::Recurrent { features, decoder, linear } => [
                features.is_valid(),
                decoder.fits(features.n_primary, self.n_aux),
                !linear.is_empty()
                    && linear.iter().all(|part| part.fits(features.n_primary, features.n_of_strokes())),
                self.adaptation.as_ref().is_none_or(|adaptation| adaptation.fits(features)),
            ],
        };
        let rest = [self.step_s > 0.0 && self.step_s.is_finite(), !self.scene_hash.is_empty()];
        let names = [
            "design.recurrent.features",
            "design.recurrent.decoder",
            "design.recurrent.linear",
            "adaptation",
            "step_s",
            "scene_sha256",
        ];
        if let Some(change) = &self.change {
            change.check(match &self.design {
                ResidualDesign::Recurrent { features, .. } => features.n_primary,
                ResidualDesign::Windowed { .. } => n_in - 3,
            })?;
        }
        match parts.into_iter().chain(rest).zip(names).find(|(fits, _)| !fits) {
            None => Ok(()),
            Some((_, part)) => Err(BadInput::new(part, "that of this network", "another")),
        }
    }

    /// Refuses a robot with other tendons, or commands at another rate.
    ///
    /// # Errors
    /// `BadInput` saying which.
    pub fn check(&self, n_primary: usize, n_aux: usize, step: f64) -> std::result::Result<(), BadInput> {
        let trained = match &self.design {
            ResidualDesign::Recurrent { features, .. } => features.n_primary,
            ResidualDesign::Windowed { .. } => self.inputs.channels.len() - 3,
        };
        if (trained, self.n_aux) != (n_primary, n_aux) {
            let expected = format!("{trained} tendons and {} auxiliary ones, as the network has", self.n_aux);
            return Err(BadInput::new("scene", expected, format!("{n_primary} and {n_aux}"))
                .hint("the network was trained for another robot or layout"));
        }
        if (step / self.step_s - 1.0).abs() > SAME_STEP {
            let expected =
                format!("samples of {} s, as in training", hysteron_base::number::shown(self.step_s));
            return Err(BadInput::new(
                "time_s",
                expected,
                format!("{} s", hysteron_base::number::shown(step)),
            )
            .hint("resample the commands"));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test may stop where it stands
    use hysteron_base::json;
    use hysteron_learn::{Architecture, ChannelRange, HeadActivation};
    use serde_json::Value;

    use super::*;

    /// Error of a checkpoint with this many inputs and details changed so; empty where it is accepted.
    fn refusal(n_inputs: usize, change: impl FnOnce(&mut Value)) -> String {
        let range = |k: usize| ChannelRange { name: format!("channel {k}"), min: 0.0, max: 1.0 };
        let channels = |n: usize| Normaliser::new((0..n).map(range).collect()).unwrap();
        let architecture = Architecture {
            inputs: n_inputs,
            hidden: 2,
            layers: 1,
            outputs: 2,
            head: HeadActivation::Tanh,
            dropout: 0.0,
        };
        let mut details = json!({
            "design": { "windowed": { "window": 4 } }, "n_aux": 2, "step_s": 0.01, "scene_sha256": "a scene",
            "adaptation": null, "training": null,
        });
        change(&mut details);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("network.safetensors");
        let network = Network::new(&architecture, 1).unwrap();
        let (inputs, outputs) = (channels(n_inputs), channels(2));
        Checkpoint { kind: KIND.into(), network, inputs, outputs, details }.write(&path).unwrap();
        ResidualModel::read(&path).map_or_else(|error| error.to_string(), |_| String::new())
    }

    #[test]
    fn parts_that_do_not_fit_are_refused() {
        assert_eq!(refusal(5, |_| ()), "");
        // Two strokes and no tip; then less than a tip.
        assert!(refusal(2, |_| ()).contains("channels: expected strokes and 3 axes"));
        assert!(refusal(3, |_| ()).contains("got 3 inputs and 2 outputs"));
        let refused = |key: &str, value: Value, words: &str| {
            let found = refusal(5, |details| details[key] = value);
            assert!(found.contains(words), "{key}: {found}");
        };
        refused("n_aux", json!(3), "channels: expected");
        refused("n_aux", json!(0), "n_aux: expected 1 to");
        refused("design", json!({ "windowed": { "window": 0 } }), "window: expected 1 to");
        refused("design", json!({ "windowed": { "window": 1_000_000_000_000u64 } }), "window: expected 1 to");
        refused("step_s", json!(0.0), "step_s");
        refused("scene_sha256", json!(""), "scene_sha256");
        refused("scene_sha256", json!(null), "details");
        let without = refusal(5, |details| drop(details.as_object_mut().unwrap().remove("scene_sha256")));
        assert!(without.contains("details"), "{without}");
    }
}
