//! A study: the whole chain from a recording to a tracked path, stage by stage.
//!
//! A stage is this program, started again with the arguments that a person would type. What it was made from stands
//! in its stamp, so that a stage is done once, and again only when something that it reads has changed.

mod convert;
#[cfg(test)]
mod fuzz;
mod schema;
mod stage;
mod stages;
mod stamp;

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::Caller;
use crate::figures;
pub use stage::{OnRefusal, Stage, Step};
pub use stages::{DATA, PREDICTED, STROKES, folder, repeat};
pub use stamp::{Stamp, Standing, make_room};

/// Carry out a study: record, calibrate, identify, learn, track, evaluate; ends in one report
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    /// Study file, .toml
    pub study: PathBuf,
    /// Folder to write to [default: out/NAME]
    #[cfg_attr(feature = "clap", arg(long, value_name = "DIR"))]
    pub out: Option<PathBuf>,
}

/// What is to be done, valid, with paths from the current folder.
#[derive(Debug)]
pub struct Study {
    /// Its name.
    pub name: String,
    /// Seed of everything random.
    pub seed: u64,
    /// Rig that measures.
    pub rig: Rig,
    /// Motions that are recorded.
    pub plan: PlanChoice,
    /// Scene of the robot.
    pub scene: SceneChoice,
    calibrate: Option<schema::Calibrate>,
    identify: Option<schema::Identify>,
    residual: Option<schema::Residual>,
    generate: Option<PlanChoice>,
    train: Option<schema::Train>,
    /// Paths to be tracked.
    pub track: Option<Track>,
}

/// A rig as `hysteron record` takes it.
#[derive(Debug)]
pub struct Rig {
    argument: stage::Argument,
    /// For people.
    pub description: String,
    /// True where it is simulated.
    pub is_virtual: bool,
    /// Where about the body its first tendon runs [rad].
    pub first_angle: f64,
}

/// A plan as `hysteron record` takes it.
#[derive(Debug)]
pub struct PlanChoice {
    argument: stage::Argument,
    /// Names and numbers of samples of the trajectories to learn from.
    pub training: Vec<(String, usize)>,
    /// The same of those to check with.
    pub checks: Vec<(String, usize)>,
}

/// A scene and its mesh.
#[derive(Debug)]
pub struct SceneChoice {
    path: PathBuf,
    mesh: PathBuf,
    /// Name of the robot.
    pub robot: String,
}

/// Paths to be tracked.
#[derive(Debug)]
pub struct Track {
    /// Where the tip shall go.
    pub targets: Vec<Target>,
    /// How strokes are found.
    pub ways: Vec<Way>,
    /// How often each is carried out.
    pub repeats: usize,
}

/// A path for the tip.
#[derive(Debug)]
pub struct Target {
    argument: stage::Argument,
    /// What its folder is called.
    pub name: String,
    /// What is to be followed.
    pub path: hysteron_control::TargetPath,
}

/// A way to strokes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Way {
    /// Through the twin of the scene without what is fitted to a robot, and without a network.
    Nominal,
    /// Through the twin of the scene as it is, without a network.
    Scene,
    /// Through the calibrated twin with its network.
    Twin,
    /// By the inverse network.
    Network,
}

impl Way {
    /// As in a study file.
    pub fn name(self) -> &'static str {
        match self {
            Self::Nominal => "nominal",
            Self::Scene => "scene",
            Self::Twin => "twin",
            Self::Network => "network",
        }
    }
}

impl Study {
    /// Whether the twin is trained to show the robot's hysteresis.
    pub fn has_residual(&self) -> bool {
        self.residual.is_some()
    }
}

/// Reads and checks a study and all that it names, and carries it out: `carry_out` is given the folder, the study
/// and its stages, and brings these to their end. Then writes the report.
///
/// # Errors
/// `BadInput` naming what is wrong, and whatever comes of `carry_out`.
pub fn run(
    options: &Options,
    carry_out: impl FnOnce(&Path, &Study, &[Stage]) -> anyhow::Result<()>,
    caller: &Caller,
) -> anyhow::Result<Value> {
    let study = Study::read(&options.study)?;
    let out = options.out.clone().unwrap_or_else(|| Path::new("out").join(&study.name));
    let stages = stages::stages(&study, &out);
    carry_out(&out, &study, &stages)?;
    let value = figures::study::write(&out, &study, &stages, caller)?;
    caller.reported(&out);
    Ok(value)
}
