//! Commands of the program, run in this process; all that they write is kept in a folder, so that a study resumes where it was
//! stopped.

use std::path::{Path, PathBuf};

use anyhow::{Context as _, ensure};
use clap::Parser;
use hysteron_base::{BadInput, file, json};
use hysteron_virtual_rig::virtual_rig::VirtualRobot;
use hysteron_workflow::rig::{identify_servo, record};
use hysteron_workflow::shared::command_line::shown;
use hysteron_workflow::shared::error::Cancelled;
use hysteron_workflow::shared::paths::plain;
use hysteron_workflow::tendon::{
    adapt, evaluate, fit_material, fit_residual, fit_sensor, generate, identify, sense, simulate, track,
    train,
};
use hysteron_workflow::{Context, Progress, ProgressSink, Silent, WorkflowError};

use super::path_following::Followed;

type Result<T> = anyhow::Result<T>;

/// Test trajectories of the plan `paper`.
pub const TESTS: [&str; 3] = ["ellipse-1", "ellipse-2", "circle-beyond"];

/// The twin with friction: the name of what it learns, in the folder of a robot, and its scene.
pub const FRICTION: (&str, &str) = ("friction", "scene-typical-friction.toml");

/// How strokes are found.
#[derive(Debug, Clone, Copy)]
pub enum Strokes<'a> {
    /// By steering the twin of a scene, with its residual network or without.
    Twin {
        /// Scene file.
        scene: &'a str,
        /// Checkpoint.
        residual: Option<&'a str>,
    },
    /// By the network of a checkpoint.
    Network(&'a str),
    /// By what the checkpoint names as best, its network or a twin.
    Best(&'a str),
}

impl<'a> Strokes<'a> {
    fn arguments(self) -> Vec<&'a str> {
        match self {
            Self::Twin { scene, residual } => ["--scene", scene].into_iter().chain(residual).collect(),
            Self::Network(model) => vec![model, "--network"],
            Self::Best(model) => vec![model],
        }
    }
}

/// A command of the program that studies run, with the options that a person would type.
#[derive(Debug, clap::Parser)]
#[command(name = "hysteron")]
enum StudyCommand {
    Record(record::Options),
    IdentifyServo(identify_servo::Options),
    FitMaterial(fit_material::Options),
    Identify(identify::Options),
    FitResidual(fit_residual::Options),
    Adapt(adapt::Options),
    Generate(generate::Options),
    Train(train::Options),
    Track(track::Options),
    Simulate(simulate::Options),
    FitSensor(fit_sensor::Options),
    Sense(sense::Options),
}

impl StudyCommand {
    fn run(&self, context: &Context) -> Result<()> {
        match self {
            Self::Record(options) => record::run(options, context).map(drop)?,
            Self::IdentifyServo(options) => identify_servo::run(options, context).map(drop)?,
            Self::FitMaterial(options) => fit_material::run(options, context).map(drop)?,
            Self::Identify(options) => identify::run(options, context).map(drop)?,
            Self::FitResidual(options) => fit_residual::run(options, context).map(drop)?,
            Self::Adapt(options) => adapt::run(options, context).map(drop)?,
            Self::Generate(options) => generate::run(options, context).map(drop)?,
            Self::Train(options) => train::run(options, context).map(drop)?,
            Self::Track(options) => track::run(options, context).map(drop)?,
            Self::Simulate(options) => simulate::run(options, context).map(drop)?,
            Self::FitSensor(options) => fit_sensor::run(options, context).map(drop)?,
            Self::Sense(options) => sense::run(options, context).map(drop)?,
        }
        Ok(())
    }
}

/// `ProgressSink` of a command that a study runs: it passes on the cancellation of the study and shows nothing.
struct Quiet<'a>(&'a dyn ProgressSink);

impl ProgressSink for Quiet<'_> {
    fn start(&self, _: &str, _: usize, _: usize) -> Box<dyn Progress> {
        Box::new(Silent)
    }

    fn is_cancelled(&self) -> bool {
        self.0.is_cancelled()
    }

    fn listen(&self) {
        self.0.listen();
    }

    fn print(&self, _: &str) {}
}

/// Commands, and where they work.
pub struct ChainCommands<'a> {
    folder: PathBuf,
    /// Folder of the robot `tpu80`.
    meshes: PathBuf,
    context: &'a Context<'a>,
}

impl<'a> ChainCommands<'a> {
    /// Commands that write to `folder`, with the meshes of the project below `repository`.
    ///
    /// # Errors
    /// `BadInput` where the meshes are not there.
    pub fn new(folder: &Path, repository: &Path, context: &'a Context<'a>) -> Result<Self> {
        let meshes = plain(&repository.join("meshes/tpu80"));
        if !meshes.join(FRICTION.1).exists() {
            let found = format!("no {}", meshes.join(FRICTION.1).display());
            return Err(BadInput::new("--repository", "the root of a checkout of the project", found).into());
        }
        Ok(Self { folder: folder.to_owned(), meshes, context })
    }

    /// The same, in the folder that the studies of `typical` next to this one's `folder` share: one
    /// calibration for all.
    ///
    /// # Errors
    /// As [`ChainCommands::new`].
    pub fn of_typical(folder: &Path, repository: &Path, context: &'a Context<'a>) -> Result<Self> {
        Self::new(&folder.with_file_name("typical"), repository, context)
    }

    /// Folder of the robot `tpu80`.
    pub fn meshes(&self) -> &Path {
        &self.meshes
    }

    /// Path of a scene, by its name in the folder of the robot, or by its whole path.
    pub fn scene_path(&self, scene: &str) -> String {
        self.meshes.join(scene).display().to_string()
    }

    /// Runs a command.
    ///
    /// # Errors
    /// It fails, or the study is to stop.
    pub fn command(&self, arguments: &[&str]) -> Result<()> {
        if self.context.is_cancelled() {
            return Err(Cancelled::new("; the same command resumes").into());
        }
        let command = shown(arguments.iter().map(|word| (*word).to_owned()));
        tracing::info!("{command}");
        let program = std::iter::once("hysteron").chain(arguments.iter().copied());
        let parsed = StudyCommand::try_parse_from(program).with_context(|| command.clone())?;
        let quiet = Quiet(self.context.progress);
        let context =
            Context { progress: &quiet, command: command.clone(), overwrite: false, watchdog: None };
        parsed.run(&context).with_context(|| command)
    }

    /// Runs it unless what it writes is there, and is not what a training was stopped at.
    ///
    /// # Errors
    /// It fails.
    pub fn once(&self, out: &str, arguments: &[&str]) -> Result<()> {
        let is_stopped =
            ["training", "training-1"].iter().any(|end| Path::new(out).with_extension(end).exists());
        if Path::new(out).exists() && !is_stopped { Ok(()) } else { self.command(arguments) }
    }

    /// Path of a result of the study, as an argument.
    ///
    /// # Errors
    /// Refusals of the file system.
    pub fn path(&self, name: &str) -> Result<String> {
        std::fs::create_dir_all(&self.folder)?;
        Ok(self.folder.canonicalize()?.join(name).display().to_string())
    }

    /// Records a plan on a virtual rig, into `name`.
    ///
    /// # Errors
    /// The program fails.
    pub fn record(&self, preset: &str, plan: &str, name: &str) -> Result<()> {
        let rig = format!("virtual:{preset}");
        self.command(&["record", "--rig", &rig, "--plan", plan, "--out", &self.path(name)?])
    }

    /// Writes the file of a robot, the preset `typical` with other lines, into `folder`; gives its name for a rig.
    ///
    /// # Errors
    /// The preset has no such line, or refusals of the file system.
    pub fn changed_robot(&self, lines: &[(&str, &str)], folder: &str) -> Result<String> {
        let text = VirtualRobot::preset_text("typical").unwrap_or_default();
        self.write_changed(text, lines, &format!("{folder}/robot.toml"))
    }

    /// Writes a text with other lines as `name`; gives its path.
    ///
    /// # Errors
    /// The text has no such line, or refusals of the file system.
    pub fn write_changed(&self, text: &str, lines: &[(&str, &str)], name: &str) -> Result<String> {
        let mut text = text.to_owned();
        for (from, to) in lines {
            ensure!(text.contains(from), "{name}: no line {from} to change");
            text = text.replace(from, to);
        }
        let path = self.path(name)?;
        file::write_bytes(Path::new(&path), text)?;
        Ok(path)
    }

    /// The recordings of the plan `paper` in `data` that are to learn from.
    ///
    /// # Errors
    /// Refusals of the file system.
    pub fn training_recordings(&self) -> Result<Vec<String>> {
        let mut names = Vec::new();
        for entry in std::fs::read_dir(self.path("data")?)? {
            let path = entry?.path();
            let is_recording = path.extension().is_some_and(|ending| ending == "parquet");
            if is_recording && !TESTS.iter().any(|test| path.file_stem().is_some_and(|stem| stem == *test)) {
                names.push(path.display().to_string());
            }
        }
        names.sort();
        Ok(names)
    }

    /// Identifies recordings with a scene of the robot, into `identified-NAME`; with `network`, a checkpoint, by
    /// what that says.
    ///
    /// # Errors
    /// The program fails.
    pub fn identify(
        &self,
        name: &str,
        scene: &str,
        network: Option<&Path>,
        recordings: &[String],
    ) -> Result<String> {
        let out = self.path(&format!("identified-{name}"))?;
        let (scene, network) = (self.scene_path(scene), network.map(|path| path.display().to_string()));
        let mut arguments = vec!["identify", &scene, "--out", &out];
        arguments.extend(network.iter().flat_map(|path| ["--residual", path]));
        arguments.extend(recordings.iter().map(String::as_str));
        self.command(&arguments)?;
        Ok(out)
    }

    /// Trains a residual network for each seed, as `NAME-SEED.safetensors`.
    ///
    /// # Errors
    /// The program fails.
    pub fn train(
        &self,
        name: &str,
        identified: &str,
        seeds: u64,
        epochs: Option<&str>,
    ) -> Result<Vec<PathBuf>> {
        let mut models = Vec::new();
        for seed in 1..=seeds {
            let out = self.path(&format!("{name}-{seed}.safetensors"))?;
            let seed = seed.to_string();
            let mut arguments = vec!["fit-residual", identified, "--seed", &seed, "--out", &out];
            arguments.extend(epochs.iter().flat_map(|epochs| ["--epochs", epochs]));
            self.once(&out, &arguments)?;
            models.push(PathBuf::from(out));
        }
        Ok(models)
    }

    /// Calibrates a twin: identification and network, and with what the twin does with that network another one for
    /// each seed, as `NAME-SEED.safetensors`.
    ///
    /// # Errors
    /// The program fails.
    pub fn calibrate(
        &self,
        name: &str,
        scene: &str,
        recordings: &[String],
        seeds: u64,
        epochs: Option<&str>,
    ) -> Result<Vec<PathBuf>> {
        let first = format!("{name}-first");
        let identified = self.identify(&first, scene, None, recordings)?;
        let network = self.train(&first, &identified, 1, epochs)?.remove(0);
        let again = self.identify(name, scene, Some(&network), recordings)?;
        self.train(name, &again, seeds, epochs)
    }

    /// Runs a plan on a calibrated twin, into the folder `name`.
    ///
    /// # Errors
    /// The program fails, or refusals of the file system.
    pub fn generate(&self, scene: &str, twin: &str, plan: &str, name: &str) -> Result<String> {
        let (file, out) = (self.path(&format!("{name}-plan.toml"))?, self.path(name)?);
        file::write_bytes(Path::new(&file), plan)?;
        self.command(&["generate", scene, "--residual", twin, "--plan", &file, "--out", &out])?;
        Ok(out)
    }

    /// Trains an inverse network, as `NAME.safetensors`.
    ///
    /// # Errors
    /// The program fails.
    pub fn train_inverse(&self, name: &str, recordings: &[String], options: &[&str]) -> Result<String> {
        let out = self.path(&format!("{name}.safetensors"))?;
        let mut arguments = vec!["train", "--out", &out];
        arguments.extend(options);
        arguments.extend(controllers(options));
        arguments.extend(recordings.iter().map(String::as_str));
        self.once(&out, &arguments)?;
        Ok(out)
    }

    /// Follows a target on a rig, several times from the noise seed `seed` on, into `name`; nothing where the rig would not
    /// carry the strokes out, so far because of the servos' load on a far path.
    ///
    /// # Errors
    /// Refusals of the file system, metrics that are none, an interruption.
    pub fn track(
        &self,
        rig: &str,
        strokes: Strokes,
        target: &str,
        [repeats, seed]: [u64; 2],
        name: &str,
    ) -> Result<Option<Vec<Followed>>> {
        let out = self.path(name)?;
        let [repeats, seed] = [repeats, seed].map(|number| number.to_string());
        let mut arguments = vec!["track", "--rig", rig, "--target", target];
        arguments.extend(["--repeats", &repeats, "--seed", &seed, "--out", &out]);
        arguments.extend(strokes.arguments());
        let found = self.tracked(&arguments, &out)?;
        let scores =
            |found: evaluate::Outcome| found.recordings.iter().map(|one| Followed::of(&one.score)).collect();
        found.map(scores).transpose()
    }

    /// The outcome of a command `track` that writes to `out`, found there or made; nothing where the rig would not carry the
    /// strokes out.
    ///
    /// # Errors
    /// As [`ChainCommands::track`].
    pub fn tracked(&self, arguments: &[&str], out: &str) -> Result<Option<evaluate::Outcome>> {
        let metrics = Path::new(out).join("metrics.json");
        if !metrics.exists() {
            match self.command(arguments).map_err(WorkflowError::from) {
                Err(error @ WorkflowError::Cancelled(_)) => return Err(error.into()),
                Err(error) => {
                    tracing::warn!("{error}");
                    return Ok(None);
                }
                Ok(()) => {}
            }
        }
        read_outcome(&metrics).map(Some)
    }
}

/// An outcome, or a part of one, that a command wrote.
///
/// # Errors
/// The file cannot be read or is no such outcome.
pub fn read_outcome<T: serde::de::DeserializeOwned>(path: &Path) -> Result<T> {
    json::from_text(file::read_text(path)?).with_context(|| path.display().to_string())
}

/// The controllers that `train` compares: all where a twin judges; else a study is of the network alone.
pub fn controllers(options: &[&str]) -> &'static [&'static str] {
    if options.contains(&"--scene") { &[] } else { &["--candidates", "network"] }
}
