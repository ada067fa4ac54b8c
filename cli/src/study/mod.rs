//! `hysteron run` and `hysteron demo`: the whole chain from a recording to a tracked path, stage by stage.
//!
//! A stage is this program, started again with the arguments that a person would type. What it was made from stands
//! in its stamp, so that a stage is done once, and again only when something that it reads has changed.

mod convert;
pub mod demo;
#[cfg(test)]
mod fuzz;
mod runner;
mod stage;
mod stages;
mod stamp;
mod typed;

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::{figures, terminal};
use runner::Runner;
pub use stage::Stage;
pub use stages::{DATA, PREDICTED, STROKES, folder, repeat};

const HELP: &str = "\
STUDY is a file that says what to do; every part but the first may be left out. Paths in it are relative to it.
  format = \"hysteron-study\"
  version = 1
  name = \"my-robot\"               # letters, digits, - and _
  seed = 1                        # of networks and of a virtual rig's days
  rig = \"virtual:typical\"         # or a rig file; as for hysteron record
  plan = \"quick\"                  # or a plan file: the motions to learn from and to check with
  scene = \"scene.toml\"            # the robot's twin, with virtual tendons ([auxiliary])

  [calibrate]                     # hysteron fit-material: the scene's numbers from recordings
  recordings = [\"circle\"]         # trajectories of the plan
  fit = [\"zero\", \"compliance\"]
  steps = 2000                    # also step_mm, every_mm; as for hysteron fit-material

  [identify]                      # virtual tendons pull the twin to the measured tip
  rounds = 1

  [residual]                      # a network learns them; also hidden
  epochs = 60
  members = 1
  passes = 2                      # and another one from what the twin does with the first; 1 without

  [generate]                      # more recordings, by the calibrated twin
  plan = \"more.toml\"              # names that are not in the other plan

  [train]                         # the inverse network: from a path to strokes; also hidden
  epochs = 20

  [track]                         # paths that nobody has learned, open loop, measured
  targets = [\"circle:40\"]         # as for hysteron target
  ways = [\"nominal\", \"scene\", \"twin\", \"network\"]
  repeats = 1                     # on as many days of a virtual rig

ways: nominal, through the twin of the scene without zeros, compliance and friction of its tendons, which are fitted to a robot; \
scene, through the twin of the scene as it is; twin, through the calibrated twin with its network; network, by \
the inverse network. The whole file, rig, plan, scene and targets are checked before anything runs.

Every stage is a verb of this program, shown as you could type it. It is done once: a stamp in OUT/stages says what it \
was made from. Change a key and run the study again: only what depends on it is done again, and what was there is \
removed; what was measured on a rig is kept, under another name. Ctrl-C, or anything worse, at any time: the same command goes on, and \
ends with the same bytes.

Writes OUT/report.html, with everything in it, OUT/metrics.json, and what every stage wrote in a folder of its own.

Examples, from the root of the repository:
  hysteron demo
  hysteron run out/demo/study.toml
  hysteron run cli/studies/paper.toml --out out/paper-003

Exit codes: 0 done, 1 failed or interrupted (run it again to go on), 2 bad input.";

/// Carry out a study: record, calibrate, identify, learn, track, evaluate; ends in one report
#[derive(Debug, clap::Args)]
#[command(after_help = HELP)]
pub struct Arguments {
    /// Study file, .toml
    study: PathBuf,
    /// Folder to write to [default: out/NAME]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
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
    calibrate: Option<typed::Calibrate>,
    identify: Option<typed::Identify>,
    residual: Option<typed::Residual>,
    generate: Option<PlanChoice>,
    train: Option<typed::Train>,
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

/// Carries out the verb.
pub fn run(arguments: &Arguments, passed_on: &[String]) -> anyhow::Result<()> {
    carry_out(&arguments.study, arguments.out.as_deref(), passed_on)
}

/// Carries out a study; `passed_on` are options of all verbs.
fn carry_out(file: &Path, out: Option<&Path>, passed_on: &[String]) -> anyhow::Result<()> {
    let study = Study::read(file)?;
    let out = out.map_or_else(|| Path::new("out").join(&study.name), Path::to_owned);
    let stages = stages::stages(&study, &out);
    Runner::new(&out, &study.name, passed_on)?.run(&stages)?;
    figures::study::write(&out, &study, &stages)?;
    terminal::say(format_args!("report: {}", out.join("report.html").display()));
    Ok(())
}
