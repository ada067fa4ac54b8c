//! Options of `train`.

use std::path::PathBuf;

use hysteron_base::BadInput;
use hysteron_control::inverse::Candidate;

use crate::shared::body::RobotBodyOptions;
use crate::shared::paper_design::{DesignName, PaperDesign};
use crate::shared::paths;

/// Train the inverse controller on recordings (EDIC)
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    /// Recordings, or folders of them
    #[cfg_attr(feature = "clap", arg(required = true, value_name = "REC"))]
    pub recordings: Vec<PathBuf>,
    /// Checkpoint to write, .safetensors
    #[cfg_attr(feature = "clap", arg(long, value_name = "CKPT"))]
    pub out: PathBuf,
    /// Scene of the robot (scene.toml): its twin compares the controllers by what their strokes do to its tip, and where it is
    /// better itself, the checkpoint names it; without it they are compared by their strokes; recurrent only
    #[cfg_attr(feature = "clap", arg(long, value_name = "SCENE"))]
    pub scene: Option<PathBuf>,
    /// Checkpoint by hysteron fit-residual, of the same scene
    #[cfg_attr(feature = "clap", arg(long, value_name = "CKPT", requires = "scene"))]
    pub residual: Option<PathBuf>,
    /// The body that moves the scene's robot.
    #[cfg_attr(feature = "clap", command(flatten))]
    pub body: RobotBodyOptions,
    /// Which network
    #[cfg_attr(feature = "clap", arg(long, value_enum, default_value_t = DesignName::Recurrent))]
    pub design: DesignName,
    /// The path has x, y and z, for a robot of several segments; else x and y
    #[cfg_attr(feature = "clap", arg(long))]
    pub spatial: bool,
    /// A recording to validate on and stop by, by name; may be given several times [default: a sixth of every kind
    /// of motion and at least one of each that has two, drawn by the seed; a kind is the family of the plan, or is
    /// found from the strokes]
    #[cfg_attr(feature = "clap", arg(long, value_name = "NAME", value_delimiter = ','))]
    pub held_out: Vec<String>,
    /// Controllers to compare on recordings that they did not learn from: the simplest that is within 5 % of the best is fitted to
    /// all data and written [default: all; the network alone for the paper's design, and for recordings with synthetic data
    /// without --scene]
    #[cfg_attr(
        feature = "clap",
        arg(long, alias = "baseline", value_enum, value_name = "NAME", value_delimiter = ',')
    )]
    pub candidates: Vec<ControllerName>,
    /// Folds of the recordings, each of which is left out in one; 1: a single split, with nothing fitted to all data afterwards
    /// [default: 3 where controllers are compared, else 1]; recurrent only
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", conflicts_with = "held_out", value_parser = crate::shared::number::count::<MAX_FOLDS>))]
    pub folds: Option<usize>,
    /// Epochs at most [default: 30, or as many as make 1000 updates of the weights; paper: 30]
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", value_parser = crate::shared::number::count::<{ hysteron_learn::MAX_EPOCHS }>))]
    pub epochs: Option<usize>,
    /// Hidden units of a layer [default: 128; paper: 512]
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", value_parser = crate::shared::number::count::<{ hysteron_learn::MAX_HIDDEN }>))]
    pub hidden: Option<usize>,
    /// Pull that all tendons have in common at least, so that none goes slack; recurrent only
    #[cfg_attr(feature = "clap", arg(long, alias = "least-pull-mm", value_name = "MM", value_parser = crate::shared::number::distance_mm))]
    pub co_contraction_min_mm: Option<f64>,
    /// Number type of the weights in the controller: int16 is faster where they do not fit a core's
    /// own cache (from a megabyte on); the change of the strokes is measured and reported; recurrent only
    #[cfg_attr(feature = "clap", arg(long, value_enum, default_value_t = Weights::Float32))]
    pub weights: Weights,
    /// Folder for report.html and metrics.json [default: OUT without its ending]
    #[cfg_attr(feature = "clap", arg(long, value_name = "DIR"))]
    pub figures: Option<PathBuf>,
    /// Numbers of the published network.
    #[cfg_attr(feature = "clap", command(flatten))]
    pub paper: PaperDesign,
    /// Seed of weights, order, noise and held-out recordings
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value_t = 1))]
    pub seed: u64,
}

/// More folds than anyone has recordings for.
#[cfg(feature = "clap")]
const MAX_FOLDS: usize = 1000;
/// Folds where controllers are compared.
pub const FOLDS: usize = 3;

/// A controller to compare.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum ControllerName {
    /// Cubic polynomials of the tip some time later
    StaticRegression,
    /// Kernel regression of what these leave, on features of the path
    KernelRegression,
    /// The network, of the recordings of the rig alone
    RecordedNetwork,
    /// The network, of all data
    Network,
}

impl ControllerName {
    pub(super) fn candidate(self) -> Candidate {
        match self {
            Self::StaticRegression => Candidate::StaticRegression,
            Self::KernelRegression => Candidate::KernelRegression,
            Self::RecordedNetwork => Candidate::RecordedNetwork,
            Self::Network => Candidate::Network,
        }
    }
}

/// Number type of the weights.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum Weights {
    /// As they were trained
    Float32,
    /// Whole numbers in 16 bits, an 8191th of the largest of their row; inputs of products too
    Int16,
}

impl Options {
    /// # Errors
    /// `BadInput` for options that the published design does not have.
    pub(super) fn check(&self) -> Result<(), BadInput> {
        paths::check_checkpoint(&self.out)?;
        if self.design == DesignName::Paper && self.co_contraction_min_mm.is_some() {
            return Err(BadInput::new("--co-contraction-min-mm", "the recurrent design", "the paper's"));
        }
        if self.design == DesignName::Paper && self.scene.is_some() {
            return Err(BadInput::new("--scene", "the recurrent design", "the paper's"));
        }
        let is_only_network = self.candidates.iter().all(|name| *name == ControllerName::Network);
        if self.design == DesignName::Paper && (!is_only_network || self.folds.unwrap_or(1) > 1) {
            let option = if is_only_network { "--folds" } else { "--candidates" };
            return Err(BadInput::new(option, "the recurrent design", "the paper's"));
        }
        if self.design == DesignName::Paper && self.weights != Weights::Float32 {
            return Err(BadInput::new("--weights", "the recurrent design", "the paper's"));
        }
        Ok(())
    }

    /// Folds for so many controllers.
    pub(super) fn n_folds(&self, n_candidates: usize) -> usize {
        let default = if n_candidates > 1 && self.held_out.is_empty() { FOLDS } else { 1 };
        self.folds.unwrap_or(default)
    }
}
