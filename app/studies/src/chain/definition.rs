//! Definition of a study.

use std::path::PathBuf;

use super::method::Method;
use super::schema;
use super::stage::Argument;

/// Definition of a study, valid, with paths from the current folder.
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
    pub(super) calibrate: Option<schema::Calibrate>,
    pub(super) identify: Option<schema::Identify>,
    pub(super) residual: Option<schema::Residual>,
    pub(super) generate: Option<PlanChoice>,
    pub(super) train: Option<schema::Train>,
    /// Paths to be tracked.
    pub track: Option<Track>,
}

/// A rig as `hysteron record` takes it.
#[derive(Debug)]
pub struct Rig {
    pub(super) argument: Argument,
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
    pub(super) argument: Argument,
    /// Names and numbers of samples of the trajectories to learn from.
    pub training: Vec<(String, usize)>,
    /// The same of those to check with.
    pub checks: Vec<(String, usize)>,
}

/// A scene and the files that it names.
#[derive(Debug)]
pub struct SceneChoice {
    pub(super) path: PathBuf,
    pub(super) mesh: PathBuf,
    pub(super) reduced: Option<PathBuf>,
    /// Name of the robot.
    pub robot: String,
}

/// Paths to be tracked.
#[derive(Debug)]
pub struct Track {
    /// Where the tip shall go.
    pub targets: Vec<Target>,
    /// How strokes are found.
    pub methods: Vec<Method>,
    /// How often each is run.
    pub repeats: usize,
}

/// A path for the tip.
#[derive(Debug)]
pub struct Target {
    pub(super) argument: Argument,
    /// Name of its folder.
    pub name: String,
    /// Path to follow.
    pub path: hysteron_control::TargetPath,
}

impl Study {
    /// Whether the twin is trained to show the robot's hysteresis.
    pub fn has_residual(&self) -> bool {
        self.residual.is_some()
    }
}
