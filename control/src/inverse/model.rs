//! A trained controller with everything its use needs.

use std::path::Path;

use hysteron_base::size::check_count;
use hysteron_base::{BadInput, Bounds};
use hysteron_learn::{Checkpoint, MAX_ROWS, Network, Normaliser, RadialBasis, WeightFormat};
use serde::{Deserialize, Serialize};

use super::{Axes, Check, FeatureSpec, InverseTraining, StaticRegression, TipWorkspace};
use crate::{Result, StrokeLimits};

/// How a path becomes the network's inputs, and its outputs strokes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum InverseDesign {
    /// The paper's: a sliding window of positions in, strokes out (eq. 12).
    Windowed {
        /// Samples of a window.
        window: usize,
    },
    /// Features of the path in, one cell update a sample, corrections of a static regression out.
    #[serde(alias = "stateful")]
    Recurrent {
        /// Inputs of the network.
        features: FeatureSpec,
        /// Static regression that the outputs correct.
        regression: StaticRegression,
        /// Kernel regression of the features, which they correct too.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        kernel: Option<Box<RadialBasis>>,
    },
}

/// The inverse controller h.
#[derive(Debug, Clone, PartialEq)]
pub struct InverseModel {
    /// Weights.
    pub network: Network,
    /// Channels that enter.
    pub inputs: Normaliser,
    /// Channels that leave.
    pub outputs: Normaliser,
    /// How they are made and used.
    pub design: InverseDesign,
    /// Number format of the recurrent design's weights while it commands.
    pub weights: WeightFormat,
    /// Number of tendons.
    pub n_tendons: usize,
    /// Duration of a sample [s].
    pub step_s: f64,
    /// Range of the training strokes, and their largest rate.
    pub limits: StrokeLimits,
    /// Tip positions in training.
    pub workspace: TipWorkspace,
    /// Hashes of the rig and the scene that it was trained for.
    pub robots: Vec<String>,
    /// Data, options, scores, command.
    pub training: InverseTraining,
}

const KIND: &str = "inverse";

/// Largest difference of a sample's duration from that of the training.
const SAME_STEP: f64 = 0.01;

/// Metadata of a checkpoint, next to the network.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct ControllerDetails {
    design: InverseDesign,
    #[serde(default)]
    weights: WeightFormat,
    n_tendons: usize,
    step_s: f64,
    stroke_min_m: f64,
    stroke_max_m: f64,
    stroke_rate_max_m_s: f64,
    workspace: TipWorkspace,
    robots_sha256: Vec<String>,
    training: InverseTraining,
}

impl InverseModel {
    /// Writes a checkpoint.
    ///
    /// # Errors
    /// Refusals of the file system.
    pub fn write(&self, path: &Path) -> Result<()> {
        let details = ControllerDetails {
            design: self.design.clone(),
            weights: self.weights,
            n_tendons: self.n_tendons,
            step_s: self.step_s,
            stroke_min_m: self.limits.stroke.min,
            stroke_max_m: self.limits.stroke.max,
            stroke_rate_max_m_s: self.limits.stroke_rate,
            workspace: self.workspace.clone(),
            robots_sha256: self.robots.clone(),
            training: self.training.clone(),
        };
        let (network, inputs, outputs) = (self.network.clone(), self.inputs.clone(), self.outputs.clone());
        Checkpoint { kind: KIND.into(), network, inputs, outputs, details }.write(path)?;
        Ok(())
    }

    /// Reads a checkpoint.
    ///
    /// # Errors
    /// Not a checkpoint, not of an inverse controller, damaged, or parts that do not fit each other.
    pub fn read(path: &Path) -> Result<Self> {
        let found: Checkpoint<ControllerDetails> = Checkpoint::read(path, KIND)?;
        let Checkpoint { network, inputs, outputs, details, .. } = found;
        let within = |bad: BadInput| bad.within(format!("{}: details", path.display()));
        let model = Self {
            network,
            inputs,
            outputs,
            design: details.design,
            weights: details.weights,
            n_tendons: details.n_tendons,
            step_s: details.step_s,
            limits: StrokeLimits {
                stroke: Bounds { min: details.stroke_min_m, max: details.stroke_max_m },
                stroke_rate: details.stroke_rate_max_m_s,
            },
            workspace: details.workspace,
            robots: details.robots_sha256,
            training: details.training,
        };
        model.check().map_err(within)?;
        Ok(model)
    }

    /// That the parts fit each other.
    fn check(&self) -> Check<()> {
        let n_inputs = match &self.design {
            InverseDesign::Windowed { window } => {
                check_count("window", *window, MAX_ROWS)?;
                self.axes().len()
            }
            InverseDesign::Recurrent { features, regression, kernel } => {
                features.check()?;
                if features.axes != self.axes() || !regression.is_for(features.axes) {
                    let of = |axes: Axes| axes.names().join(", ");
                    let found = format!("features of {}, outputs of {}", of(features.axes), of(self.axes()));
                    return Err(BadInput::new("design", "the same axes throughout", found));
                }
                if [features.n_tendons, regression.n_tendons()] != [self.n_tendons; 2] {
                    let found = format!("{} and {}", features.n_tendons, regression.n_tendons());
                    return Err(BadInput::new("design", format!("{} tendons", self.n_tendons), found));
                }
                let n_inputs = features.names().len();
                if let Some(kernel) = kernel {
                    kernel.check()?;
                    let found = [kernel.n_inputs(), kernel.n_outputs()];
                    if found != [n_inputs, self.n_tendons] {
                        let expected = format!("{n_inputs} inputs and {} outputs", self.n_tendons);
                        return Err(BadInput::new("design: kernel", expected, format!("{found:?}")));
                    }
                }
                n_inputs
            }
        };
        let found = [self.inputs.channels.len(), self.outputs.channels.len()];
        if found != [n_inputs, self.n_tendons] {
            let expected = format!("{n_inputs} inputs and {} outputs", self.n_tendons);
            let [n_in, n_out] = found;
            return Err(BadInput::new("design", expected, format!("{n_in} and {n_out}")));
        }
        check_limits(&self.limits)
    }

    /// Refuses a path at another rate.
    ///
    /// # Errors
    /// `BadInput` with both.
    pub fn check_step(&self, step: f64) -> Check<()> {
        if (step / self.step_s - 1.0).abs() > SAME_STEP {
            let expected =
                format!("samples of {} s, as in training", hysteron_base::number::shown(self.step_s));
            return Err(BadInput::new(
                "time_s",
                expected,
                format!("{} s", hysteron_base::number::shown(step)),
            )
            .hint("resample the target"));
        }
        Ok(())
    }

    /// Coordinates of a tip.
    pub fn axes(&self) -> Axes {
        if self.workspace.height_m.is_some() { Axes::Spatial } else { Axes::Planar }
    }

    /// Size of the network in words, `2 x 512`.
    pub fn size(&self) -> String {
        let architecture = self.network.architecture();
        format!("{} x {}", architecture.layers, architecture.hidden)
    }
}

/// Refuses limits that leave nothing or are not numbers.
pub(super) fn check_limits(limits: &StrokeLimits) -> Check<()> {
    let Bounds { min, max } = limits.stroke;
    if !(min <= max && (max - min).is_finite()) {
        return Err(BadInput::new("strokes", "finite min <= max", format!("{min} to {max} m")));
    }
    if !(limits.stroke_rate > 0.0 && limits.stroke_rate.is_finite()) {
        let found = format!("{} m/s", limits.stroke_rate);
        return Err(BadInput::new("stroke rate", "a rate > 0", found));
    }
    Ok(())
}
