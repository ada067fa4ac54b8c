//! Options of `fit-material`.

use std::path::PathBuf;

use hysteron_base::BadInput;
use hysteron_twin::fit::TipFrame;

use crate::shared::body::RobotBodyOptions;

/// More than any set of recordings has.
pub const MAX_STEPS: usize = 10_000_000;

/// Fit modulus, zero offsets and the like to recordings
///
/// Finds the parameters with which the twin's tip comes nearest to the measured one, with standard errors.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    /// Scene file of the robot (scene.toml)
    pub scene: PathBuf,
    /// The body that moves it.
    #[cfg_attr(feature = "clap", command(flatten))]
    pub body: RobotBodyOptions,
    /// Recordings with commands and tip, or folders of them
    #[cfg_attr(feature = "clap", arg(required = true, value_name = "REC"))]
    pub recordings: Vec<PathBuf>,
    /// Scene file to write
    #[cfg_attr(feature = "clap", arg(long, value_name = "SCENE"))]
    pub out: PathBuf,
    /// Folder for figures, report.html and metrics.json
    #[cfg_attr(feature = "clap", arg(long, value_name = "DIR"))]
    pub figures: Option<PathBuf>,
    /// Write each figure as .png too
    #[cfg_attr(feature = "clap", arg(long, requires = "figures"))]
    pub png: bool,
    /// Parameters to fit, by name
    #[cfg_attr(feature = "clap", arg(long, value_name = "NAME,...", value_delimiter = ',', default_values_t = default_names()))]
    pub fit: Vec<String>,
    /// File with the parameters to fit and their bounds, in place of --fit
    #[cfg_attr(feature = "clap", arg(long, value_name = "TOML", conflicts_with = "fit"))]
    pub fit_file: Option<PathBuf>,
    /// Take only recordings made for this: training, validation or test
    #[cfg_attr(feature = "clap", arg(long, value_name = "ROLE"))]
    pub role: Option<String>,
    /// Step through samples between which a stroke (or, under tension, the tip) moves at most so far; samples where a
    /// stroke turns back are among them
    #[cfg_attr(feature = "clap", arg(long, value_name = "MM", default_value_t = 0.3, value_parser = crate::shared::number::length_mm))]
    pub step_mm: f64,
    /// Compare the tip where a stroke has moved so far since it was compared last
    #[cfg_attr(feature = "clap", arg(long, value_name = "MM", default_value_t = 0.2, value_parser = crate::shared::number::length_mm))]
    pub every_mm: f64,
    /// Most steps of an evaluation, shared evenly by the recordings: of each, the beginning
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value_t = 2000, value_parser = crate::shared::number::count::<MAX_STEPS>))]
    pub steps: usize,
    /// Largest tension that the drives can make [default: tension_max_n of the scene]; what needs more than four
    /// fifths of it fits the worse
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", value_parser = crate::shared::number::weight))]
    pub tension_max_n: Option<f64>,
    /// Error of a coordinate from which on it counts linearly rather than squared
    #[cfg_attr(feature = "clap", arg(long, value_name = "MM", value_parser = crate::shared::number::length_mm))]
    pub huber_mm: Option<f64>,
    /// Frame of the measured tip: the scene's (a tip that rests elsewhere is refused), the scene's wherever the tip
    /// rests, or one to be found
    #[cfg_attr(feature = "clap", arg(long, value_enum, default_value_t = FrameChoice::Scene))]
    pub frame: FrameChoice,
}

/// Orientation of the recordings' frame relative to gravity.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum FrameChoice {
    /// As in the scene, and checked
    Scene,
    /// As in the scene
    Trust,
    /// Fitted
    Fit,
}

impl From<FrameChoice> for TipFrame {
    fn from(choice: FrameChoice) -> Self {
        match choice {
            FrameChoice::Scene => Self::Checked,
            FrameChoice::Trust => Self::Trusted,
            FrameChoice::Fit => Self::Fitted,
        }
    }
}

#[cfg(feature = "clap")]
fn default_names() -> Vec<String> {
    ["youngs_modulus", "zero", "compliance"].map(str::to_owned).to_vec()
}

impl Options {
    /// # Errors
    /// `BadInput` for an output that is no scene.
    pub(super) fn check(&self) -> Result<(), BadInput> {
        if self.out.extension().is_none_or(|extension| extension != "toml") {
            let found = self.out.display().to_string();
            return Err(BadInput::new("--out", "a name ending in .toml", found));
        }
        Ok(())
    }
}
