//! Ablations of a robot, made by commands of the program, and their errors on test trajectories.

use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result};
use hysteron_base::Recording;
use hysteron_control::score::{PathScore, score};
use hysteron_workflow::tendon::simulate;
use rayon::prelude::*;

use super::outcome::{PathErrors, Stability, TwinErrors, TwinTable};
use super::random_plan::random_plan;
use crate::tendon::commands::{ChainCommands, FRICTION, read_outcome};

/// The twin without and with friction.
pub(super) const SCENES: [(&str, &str); 2] = [("twin", "scene-typical.toml"), FRICTION];
/// The paper's training takes every sample as the end of a window; this takes every fortieth, for its time.
const PAPER_STRIDE: &str = "40";

/// A twin: what it is, and its networks, one for each seed; none in the place of one where there is none.
pub(crate) struct TwinModels {
    /// Name of the twin.
    pub name: String,
    /// Its scene, in the robot's folder or by its whole path.
    pub scene: String,
    /// Checkpoints.
    pub models: Vec<Option<PathBuf>>,
}

/// Commands, and the test trajectories of the twins that they make.
pub(crate) struct TwinAblation<'a> {
    /// Commands.
    pub chain: ChainCommands<'a>,
    /// Test trajectories.
    pub tests: &'static [&'static str],
}

impl TwinAblation<'_> {
    /// The twins of a robot, without and with networks trained on `training`; with friction and network comes
    /// last.
    ///
    /// # Errors
    /// The program fails.
    pub fn models(
        &self,
        training: &[String],
        seeds: [u64; 2],
        epochs: Option<&str>,
    ) -> Result<Vec<TwinModels>> {
        let mut twins = Vec::new();
        for ((name, scene), seeds) in SCENES.into_iter().zip(seeds) {
            let bare = TwinModels { name: name.to_owned(), scene: scene.to_owned(), models: vec![None] };
            let models = self.chain.calibrate(name, scene, training, seeds, epochs)?;
            let models = models.into_iter().map(Some).collect();
            let learned = TwinModels { name: format!("{name} + CoReAct"), scene: scene.to_owned(), models };
            twins.extend([bare, learned]);
        }
        Ok(twins)
    }

    /// Trains the paper's network, without friction.
    ///
    /// # Errors
    /// A command fails.
    pub fn train_paper(&self, epochs: Option<&str>) -> Result<PathBuf> {
        let [out, identified] =
            ["paper.safetensors", "identified-twin-first"].map(|name| self.chain.path(name));
        let (out, identified) = (out?, identified?);
        let mut arguments =
            vec!["fit-residual", &identified, "--design", "paper", "--stride", PAPER_STRIDE, "--out", &out];
        arguments.extend(epochs.iter().flat_map(|epochs| ["--epochs", epochs]));
        self.chain.once(&out, &arguments)?;
        Ok(PathBuf::from(out))
    }

    /// Rolls out every model of every twin on every test among the recordings in `data`.
    ///
    /// # Errors
    /// The program fails.
    pub fn roll_out(&self, models: &[TwinModels], data: &str, robot: &str) -> Result<TwinTable> {
        let twins = models.iter().map(|twin| self.evaluate(twin, data)).collect::<Result<_>>()?;
        Ok(TwinTable { robot: robot.to_owned(), twins })
    }

    fn evaluate(&self, twin: &TwinModels, data: &str) -> Result<TwinErrors> {
        let mut row = TwinErrors { twin: twin.name.clone(), nrmse: Vec::new() };
        for test in self.tests {
            let strokes = self.chain.path(&format!("{data}/{test}.parquet"))?;
            let of_model = |model: &Option<PathBuf>| -> Result<[f64; 3]> {
                let stem = model.as_ref().and_then(|path| path.file_stem());
                let stem = stem.map_or_else(|| twin.name.as_str().into(), |stem| stem.to_string_lossy());
                let name = format!("rollouts-{data}/{stem}-{test}");
                let found = self.simulate(&twin.scene, &strokes, model.as_deref(), &name)?;
                let mut nrmse = [0.0; 3];
                for (value, axis) in nrmse.iter_mut().zip(&found.axes) {
                    *value = 100.0 * axis.nrmse.context("no NRMSE of a simulation")?;
                }
                Ok(nrmse)
            };
            let found = twin.models.par_iter().map(of_model).collect::<Result<Vec<[f64; 3]>>>()?;
            let axes = std::array::from_fn(|axis| found.iter().map(|of| of[axis]).collect());
            row.nrmse.push(PathErrors::new(test, axes));
        }
        Ok(row)
    }

    /// The tests where the tracker does not drift; and what its drift is, the tip measured with it against the one
    /// without.
    pub fn steady(&self, models: &[TwinModels]) -> Result<TwinTable> {
        let robot = self.chain.changed_robot(&[("bias_mm = 0.15", "bias_mm = 0.0")], "steady-robot")?;
        self.chain.record(&robot, "paper", "steady")?;
        let mut table = self.roll_out(models, "steady", "typical, by a tracker without drift")?;
        let drift = |test: &&'static str| -> Result<_> {
            let [with, without] = ["data", "steady"].map(|data| -> Result<Recording> {
                Ok(Recording::read(self.chain.path(&format!("{data}/{test}.parquet"))?)?)
            });
            let (with, without) = (with?, without?);
            let tips = without.tip().zip(with.tip());
            let (measured, drifting) = tips.context("no tip in a recording")?;
            let found = score(measured, drifting, without.gap());
            Ok(PathErrors::new(test, found.axes.map(|axis| vec![100.0 * axis.nrmse.unwrap_or(0.0)])))
        };
        let nrmse = self.tests.iter().map(drift).collect::<Result<_>>()?;
        table.twins.insert(0, TwinErrors { twin: "the drift alone".to_owned(), nrmse });
        Ok(table)
    }

    /// Simulates; how far its tip is from the measured one.
    fn simulate(&self, scene: &str, strokes: &str, model: Option<&Path>, name: &str) -> Result<PathScore> {
        let (scene, out, figures) = (
            self.chain.scene_path(scene),
            self.chain.path(&format!("{name}.parquet"))?,
            self.chain.path(name)?,
        );
        let model = model.map(|path| path.display().to_string());
        let mut arguments = vec!["simulate", &scene, "--strokes", strokes];
        arguments.extend(["--out", &out, "--figures", &figures]);
        arguments.extend(model.iter().flat_map(|path| ["--residual", path]));
        let metrics = Path::new(&figures).join("metrics.json");
        if !metrics.exists() {
            self.chain.command(&arguments)?;
        }
        let found: simulate::Outcome = read_outcome(&metrics)?;
        found.run.against_measured.context("a simulation without measured tip")
    }

    /// Rollouts on random plans, half of them within the amplitudes of training and half up to 20 % beyond.
    pub fn stability(&self, n: usize) -> Result<Stability> {
        let model = PathBuf::from(self.chain.path("friction-1.safetensors")?);
        let plan = self.chain.path("random.toml")?;
        std::fs::write(&plan, random_plan(n))?;
        self.chain.record("typical", &plan, &format!("random-{n}"))?;
        let gain = |k: usize| -> Result<f64> {
            let strokes = self.chain.path(&format!("random-{n}/random-{k}.parquet"))?;
            let rmse = |model: Option<&Path>, name: &str| -> Result<f64> {
                Ok(self.simulate(SCENES[1].1, &strokes, model, &format!("stability/{name}-{k}"))?.rmse_m)
            };
            Ok(rmse(Some(&model), "residual")? / rmse(None, "bare")?)
        };
        let gains = (0..n).into_par_iter().map(gain).collect::<Result<Vec<f64>>>()?;
        let worse: Vec<usize> = (0..n).filter(|&k| gains[k] > 1.1).collect();
        Ok(Stability { ratio_to_bare: gains, worse_by_10_percent: worse })
    }
}
