//! The program, stage by stage, with everything kept in a folder: a study goes on where it was stopped.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, ensure};
use hysteron_base::{file, json};
use hysteron_virtual_rig::virtual_rig::VirtualRobot;
use serde_json::Value;

use super::followed::Followed;
use super::rig::{call, program};

/// Test trajectories of the plan `paper`.
pub const TESTS: [&str; 3] = ["ellipse-1", "ellipse-2", "circle-beyond"];

/// The twin with friction: the name of what it learns, in the folder of a robot, and its scene.
pub const FRICTION: (&str, &str) = ("friction", "scene-typical-friction.toml");

/// Where a scene is, by its name in the folder of the robot, or by its whole path.
pub fn scene_path(scene: &str) -> String {
    Path::new("meshes/tpu80").join(scene).display().to_string()
}

/// How strokes are found: by a network alone, or by steering the twin of a scene, with its network or without.
#[derive(Debug, Clone, Copy)]
pub struct Strokes<'a> {
    /// Scene file.
    pub scene: Option<&'a str>,
    /// Checkpoint.
    pub model: Option<&'a str>,
}

/// The program and where it works.
pub struct Chain {
    program: PathBuf,
    folder: PathBuf,
}

impl Chain {
    /// Builds the program.
    ///
    /// # Errors
    /// It cannot be built.
    pub fn new(folder: &Path) -> Result<Self> {
        Ok(Self { program: program()?, folder: folder.to_owned() })
    }

    /// The same, in the folder that the studies of `typical` next to this one's `folder` share: one
    /// calibration for all.
    ///
    /// # Errors
    /// It cannot be built.
    pub fn of_typical(folder: &Path) -> Result<Self> {
        Self::new(&folder.with_file_name("typical"))
    }

    /// Runs it, from the root of the repository.
    ///
    /// # Errors
    /// It fails.
    pub fn hysteron(&self, arguments: &[&str]) -> Result<()> {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
        call(Command::new(&self.program).args(arguments).current_dir(root))
    }

    /// Runs it unless what it writes is there, and is not what a training was stopped at.
    ///
    /// # Errors
    /// It fails.
    pub fn once(&self, out: &str, arguments: &[&str]) -> Result<()> {
        let is_stopped =
            ["training", "training-1"].iter().any(|end| Path::new(out).with_extension(end).exists());
        if Path::new(out).exists() && !is_stopped { Ok(()) } else { self.hysteron(arguments) }
    }

    /// A path of the study as an argument: the program works in the root of the repository.
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
        self.hysteron(&["record", "--rig", &rig, "--plan", plan, "--out", &self.path(name)?])
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
        let (scene, network) = (scene_path(scene), network.map(|path| path.display().to_string()));
        let mut arguments = vec!["identify", &scene, "--out", &out];
        arguments.extend(network.iter().flat_map(|path| ["--residual", path]));
        arguments.extend(recordings.iter().map(String::as_str));
        self.hysteron(&arguments)?;
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
        self.hysteron(&["generate", scene, "--residual", twin, "--plan", &file, "--out", &out])?;
        Ok(out)
    }

    /// Trains an inverse network, as `NAME.safetensors`.
    ///
    /// # Errors
    /// The program fails.
    pub fn train_inverse(&self, name: &str, recordings: &[String], options: &[&str]) -> Result<String> {
        let out = self.path(&format!("{name}.safetensors"))?;
        let mut arguments = vec!["-q", "train", "--out", &out];
        arguments.extend(options);
        arguments.extend(recordings.iter().map(String::as_str));
        self.once(&out, &arguments)?;
        Ok(out)
    }

    /// Follows a target on a rig, several times from the day `seed` on, into `name`; nothing where the rig would not
    /// carry the strokes out: the program has said why, so far because of the servos' load on a far path.
    ///
    /// # Errors
    /// Refusals of the file system, metrics that are none.
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
        let mut arguments = vec!["-q", "--threads", "1", "track", "--rig", rig, "--target", target];
        arguments.extend(["--repeats", &repeats, "--seed", &seed, "--out", &out]);
        arguments.extend(strokes.scene.iter().flat_map(|scene| ["--scene", scene]));
        arguments.extend(strokes.model);
        let metrics = Path::new(&out).join("metrics.json");
        if !metrics.exists() && self.hysteron(&arguments).is_err() {
            return Ok(None);
        }
        let found: Value = json::from_text(&std::fs::read(metrics)?)?;
        let rows = found["recordings"].as_array().context("no recordings in metrics.json")?;
        let row = |row: &Value| -> Result<Followed> {
            let number = |key: &str| row[key].as_f64().with_context(|| format!("no {key} in metrics.json"));
            Ok(Followed {
                nrmse_percent: 100.0 * number("nrmse")?,
                iou: number("iou")?,
                aligned_rmse_mm: row["aligned_rmse_m"].as_f64().map(|m| 1e3 * m),
                lag_ms: row["lag_s"].as_f64().map(|s| 1e3 * s),
            })
        };
        rows.iter().map(row).collect::<Result<Vec<_>>>().map(Some)
    }
}
