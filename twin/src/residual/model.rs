//! A trained residual network with everything a rollout needs.

use std::path::Path;

use hysteron_base::BadInput;
use hysteron_base::size::check_count;
use hysteron_learn::{Checkpoint, MOST_ROWS, Network, Normaliser};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::linear::one_or_more;
use super::{Adaptation, Decoder, FeatureSpec, LinearPart, RobotChange};
use crate::Result;

/// How network and twin go together.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Design {
    /// The paper's: a window of strokes and tips (eq. 9).
    Windowed {
        /// Samples of a window.
        window: usize,
    },
    /// One cell update a sample.
    Stateful {
        /// What the network sees.
        features: FeatureSpec,
        /// What its outputs mean.
        decoder: Decoder,
        /// What is added to its outputs: the mean of these, one for each network that the mean of networks is made of.
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
    pub design: Design,
    /// Auxiliary tendons that it drives.
    pub n_aux: usize,
    /// Duration of a sample [s].
    pub step_s: f64,
    /// Hash of the scene that it was trained for.
    pub scene_hash: String,
    /// How the robot has changed since, as far as a few physical numbers say it.
    pub change: Option<RobotChange>,
    /// What else was learned of the robot since.
    pub adaptation: Option<Adaptation>,
    /// Data, seed, scores.
    pub training: Value,
}

const KIND: &str = "residual";

/// Largest difference of a sample's duration from that of the training.
const SAME_STEP: f64 = 0.01;

impl ResidualModel {
    /// Writes a checkpoint.
    ///
    /// # Errors
    /// Refusals of the file system.
    pub fn write(&self, path: &Path) -> Result<()> {
        let details = json!({
            "design": self.design, "n_aux": self.n_aux, "step_s": self.step_s,
            "scene_sha256": self.scene_hash, "change": self.change,
            "adaptation": self.adaptation, "training": self.training,
        });
        let (network, inputs, outputs) = (self.network.clone(), self.inputs.clone(), self.outputs.clone());
        Checkpoint { kind: KIND.into(), network, inputs, outputs, details }.write(path)?;
        Ok(())
    }

    /// Reads a checkpoint.
    ///
    /// # Errors
    /// Not a checkpoint, not of a residual network, damaged.
    pub fn read(path: &Path) -> Result<Self> {
        let Checkpoint { network, inputs, outputs, details, .. } = Checkpoint::read(path, KIND)?;
        let of = |key: &str| details.get(key).cloned().unwrap_or_default();
        let text = |key: &str| of(key).as_str().unwrap_or_default().to_owned();
        let bad = |error: serde_json::Error| {
            BadInput::new(
                format!("{}: details", path.display()),
                "those of a residual network",
                error.to_string(),
            )
        };
        let design = serde_json::from_value(of("design")).map_err(bad)?;
        let adaptation: Option<Adaptation> = serde_json::from_value(of("adaptation")).map_err(bad)?;
        let change: Option<RobotChange> = serde_json::from_value(of("change")).map_err(bad)?;
        let n_aux = serde_json::from_value(of("n_aux")).map_err(bad)?;
        let [decodes, adds, adapts] = match (&design, &adaptation) {
            (Design::Stateful { features, decoder, linear }, adaptation) => [
                decoder.fits(features.n_primary, n_aux),
                !linear.is_empty()
                    && linear.iter().all(|part| part.fits(features.n_primary, features.n_of_strokes())),
                adaptation.as_ref().is_none_or(|adaptation| adaptation.fits(features)),
            ],
            (Design::Windowed { window }, adaptation) => {
                check_count("window", *window, MOST_ROWS).map_err(|bad| bad.within(path.display()))?;
                if inputs.channels.len() < 4 {
                    let found = inputs.channels.len().to_string();
                    let place = format!("{}: inputs", path.display());
                    return Err(BadInput::new(place, "a stroke or more, and the tip", found).into());
                }
                [true, true, adaptation.is_none()]
            }
        };
        let parts = ["design.stateful.decoder", "design.stateful.linear", "adaptation"];
        for (fits, part) in [decodes, adds, adapts].into_iter().zip(parts) {
            if !fits {
                let place = format!("{}: {part}", path.display());
                return Err(BadInput::new(place, "that of this network", "another").into());
            }
        }
        if let Some(change) = &change {
            let n_primary = match &design {
                Design::Stateful { features, .. } => features.n_primary,
                Design::Windowed { .. } => inputs.channels.len().saturating_sub(3),
            };
            change.check(n_primary).map_err(|bad| bad.within(path.display()))?;
        }
        Ok(Self {
            design,
            change,
            adaptation,
            n_aux,
            step_s: serde_json::from_value(of("step_s")).map_err(bad)?,
            scene_hash: text("scene_sha256"),
            training: of("training"),
            network,
            inputs,
            outputs,
        })
    }

    /// Refuses a robot with other tendons, or commands at another rate.
    ///
    /// # Errors
    /// `BadInput` saying which.
    pub fn check(&self, n_primary: usize, n_aux: usize, step: f64) -> std::result::Result<(), BadInput> {
        let trained = match &self.design {
            Design::Stateful { features, .. } => features.n_primary,
            Design::Windowed { .. } => self.inputs.channels.len() - 3,
        };
        if (trained, self.n_aux) != (n_primary, n_aux) {
            let expected = format!("{trained} tendons and {} virtual ones, as the network has", self.n_aux);
            return Err(BadInput::new("scene", expected, format!("{n_primary} and {n_aux}"))
                .hint("the network was trained for another robot or layout"));
        }
        if (step / self.step_s - 1.0).abs() > SAME_STEP {
            let expected = format!("samples of {} s, as in training", self.step_s);
            return Err(BadInput::new("time_s", expected, format!("{step} s")).hint("resample the commands"));
        }
        Ok(())
    }
}
