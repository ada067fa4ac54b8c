//! From a study to its stages, in order.

use std::path::{Path, PathBuf};

use super::definition::{Study, Target, Track};
use super::method::Method;
use super::schema::Residual;
use super::stage::{Argument, OnRefusal, Outdated, Restart, Stage, Step};

/// Recordings by the rig.
pub const DATA: &str = "data";
/// Predictions of the calibrated twin for the validation trajectories, with its network and without.
pub const PREDICTED: [&str; 2] = ["predicted/with", "predicted/without"];
/// Everything about tracked paths, by target and method.
const TRACKED: &str = "tracked";
/// Checkpoint of a residual network, in its folder.
const NETWORK: &str = "network.safetensors";
/// Strokes that were found for a path.
pub const STROKES: &str = "strokes.parquet";

/// Guesses of what takes how long on two cores [s], for a first word on the time left: by sample, and where something
/// is learned by sample and epoch.
const PER_RECORDED: f64 = 2e-4;
const PER_MEASURED: f64 = 1e-2;
const PER_IDENTIFIED: f64 = 6e-3;
const PER_SIMULATED: f64 = 2e-3;
const PER_LED: f64 = 4e-3;
const PER_RESIDUAL_EPOCH: f64 = 6e-6;
const PER_INVERSE_EPOCH: f64 = 3e-5;
/// By step of an evaluation.
const PER_CALIBRATION_STEP: f64 = 1e-2;

/// Puts the stages of a study together.
struct Planner<'a> {
    study: &'a Study,
    out: &'a Path,
    is_calibrated: bool,
}

/// The stages of a study that is written to `out`.
pub fn stages(study: &Study, out: &Path) -> Vec<Stage> {
    let planner = Planner { study, out, is_calibrated: study.calibrate.is_some() };
    let mut stages = vec![planner.record()];
    stages.extend(planner.calibrate());
    stages.extend(planner.identify());
    stages.extend(planner.residual());
    stages.extend(planner.predict());
    stages.extend(planner.generate());
    stages.extend(planner.train());
    if let Some(track) = &study.track {
        for target in &track.targets {
            stages.extend(track.methods.iter().map(|method| planner.track(track, target, *method)));
        }
    }
    stages
}

/// Verb and arguments, word by word.
fn step(verb: &str) -> Step {
    Step { arguments: vec![Argument::word(verb)], on_refusal: OnRefusal::Fail }
}

impl Step {
    fn word(self, word: impl Into<String>) -> Self {
        self.with(Argument::word(word))
    }

    fn with(mut self, argument: Argument) -> Self {
        self.arguments.push(argument);
        self
    }

    /// An option with its value, if there is one.
    fn option(self, name: &str, value: Option<impl ToString>) -> Self {
        match value {
            Some(value) => self.word(name).word(value.to_string()),
            None => self,
        }
    }
}

impl Planner<'_> {
    /// Argument for an output of an earlier stage.
    fn made(&self, name: impl AsRef<Path>) -> Argument {
        let path = self.out.join(&name);
        Argument { reads: vec![path], ..self.written(name) }
    }

    /// Argument for an output of this stage.
    fn written(&self, name: impl AsRef<Path>) -> Argument {
        let typed = self.out.join(&name).display().to_string();
        Argument { typed, key: name.as_ref().display().to_string(), reads: Vec::new() }
    }

    fn recording(&self, name: &str) -> Argument {
        self.made(Path::new(DATA).join(format!("{name}.parquet")))
    }

    /// The scene as the person gave it.
    fn nominal_scene(&self) -> Argument {
        self.with_body(Argument::file(&self.study.scene.path))
    }

    /// The scene with fitted numbers, if they were fitted.
    fn scene(&self) -> Argument {
        if self.is_calibrated {
            self.with_body(self.made("calibrated/scene.toml"))
        } else {
            self.nominal_scene()
        }
    }

    /// A scene that leads to mesh and reduced body.
    fn with_body(&self, scene: Argument) -> Argument {
        let argument = scene.with(&self.study.scene.mesh);
        self.study.scene.reduced.iter().fold(argument, |argument, file| argument.with(file))
    }

    fn checkpoint(&self) -> Argument {
        self.made(Path::new("residual").join(NETWORK))
    }

    fn samples(of: &[(String, usize)]) -> f64 {
        of.iter().map(|(_, n)| *n as f64).sum()
    }

    /// A stage of one command, whose results can be computed again.
    fn stage(&self, name: &str, folder: impl Into<PathBuf>, about: &str, step: Step, guess: f64) -> Stage {
        Stage {
            name: name.to_owned(),
            about: about.to_owned(),
            folder: folder.into(),
            steps: vec![step],
            restart: Restart::Afresh,
            outdated: Outdated::Remove,
            guess,
        }
    }

    /// Handling of outdated recordings: those of a rig with ports take time to measure, and are kept.
    fn outdated(&self) -> Outdated {
        if self.study.rig.is_virtual { Outdated::Remove } else { Outdated::SetAside }
    }

    fn per_recorded(&self) -> f64 {
        if self.study.rig.is_virtual { PER_RECORDED } else { PER_MEASURED }
    }

    fn record(&self) -> Stage {
        let Study { rig, plan, seed, .. } = self.study;
        let step = step("record")
            .word("--rig")
            .with(rig.argument.clone())
            .word("--plan")
            .with(plan.argument.clone());
        let step = step.option("--seed", Some(seed)).word("--out").with(self.written(DATA));
        let about = "the rig moves through the plan; strokes and tip are recorded";
        let n = Self::samples(&plan.training) + Self::samples(&plan.checks);
        let guess = n * self.per_recorded();
        let stage = self.stage("record", DATA, about, step, guess);
        Stage { restart: Restart::GoesOn, outdated: self.outdated(), ..stage }
    }

    fn calibrate(&self) -> Option<Stage> {
        let calibrate = self.study.calibrate.as_ref()?;
        let mut step = step("fit-material").with(self.nominal_scene());
        for name in &calibrate.recordings {
            step = step.with(self.recording(name));
        }
        let step = step
            .option("--fit", Some(calibrate.fit.join(",")))
            .option("--steps", calibrate.steps)
            .option("--step-mm", calibrate.step_mm)
            .option("--every-mm", calibrate.every_mm)
            .word("--out")
            .with(self.written("calibrated/scene.toml"))
            .word("--figures")
            .with(self.written("calibrated/report"));
        let about = "the twin's numbers are fitted to the recordings";
        let guess = PER_CALIBRATION_STEP * calibrate.steps.unwrap_or(6000) as f64;
        Some(self.stage("calibrate", "calibrated", about, step, guess))
    }

    /// The verb with the scene and all recordings to learn from.
    fn identification(&self) -> Step {
        let step = step("identify").with(self.scene());
        self.study.plan.training.iter().fold(step, |step, (name, _)| step.with(self.recording(name)))
    }

    fn identify(&self) -> Option<Stage> {
        let identify = self.study.identify.as_ref()?;
        let step = self
            .identification()
            .option("--rounds", identify.rounds)
            .word("--out")
            .with(self.written("identified"));
        let about = "auxiliary tendons are found that pull the twin's tip to the measured one";
        let guess =
            PER_IDENTIFIED * identify.rounds.unwrap_or(2) as f64 * Self::samples(&self.study.plan.training);
        let stage = self.stage("identify", "identified", about, step, guess);
        Some(Stage { restart: Restart::GoesOn, ..stage })
    }

    /// A network; with two passes, another one, which learns from what the twin does with the first.
    fn residual(&self) -> Vec<Stage> {
        let Some(residual) = &self.study.residual else { return Vec::new() };
        if residual.passes.unwrap_or(1) < 2 {
            return vec![self.fit_residual(residual, "identified", "residual")];
        }
        let first = "residual-first";
        let step = self.identification().word("--residual").with(self.made(Path::new(first).join(NETWORK)));
        let step = step.word("--out").with(self.written("identified-again"));
        let about = "the twin goes along the recordings with its network, to see what that leaves";
        let guess = 2.0 * PER_SIMULATED * Self::samples(&self.study.plan.training);
        let again = self.stage("identify-again", "identified-again", about, step, guess);
        vec![
            Stage {
                name: "fit-residual-first".to_owned(),
                ..self.fit_residual(residual, "identified", first)
            },
            Stage { restart: Restart::GoesOn, ..again },
            self.fit_residual(residual, "identified-again", "residual"),
        ]
    }

    fn fit_residual(&self, residual: &Residual, identified: &str, folder: &str) -> Stage {
        let step = step("fit-residual")
            .with(self.made(identified))
            .option("--epochs", residual.epochs)
            .option("--hidden", residual.hidden)
            .option("--members", residual.members)
            .option("--seed", Some(self.study.seed))
            .word("--out")
            .with(self.written(Path::new(folder).join(NETWORK)));
        let about =
            "a network learns what the auxiliary tendons do, so that the twin shows hysteresis by itself";
        let epochs = (residual.epochs.unwrap_or(100) * residual.members.unwrap_or(3)) as f64;
        let guess = PER_RESIDUAL_EPOCH * epochs * Self::samples(&self.study.plan.training);
        self.stage("fit-residual", folder, about, step, guess)
    }

    /// Stages that predict trajectories outside the training set, with the twin's network and without.
    fn predict(&self) -> Vec<Stage> {
        if self.study.residual.is_none() {
            return Vec::new();
        }
        let stage = |name: &str, n: usize, folder: &str, has_network: bool| {
            let strokes = self.recording(name);
            let step = step("simulate").with(self.scene()).word("--strokes").with(strokes);
            let step = if has_network { step.word("--residual").with(self.checkpoint()) } else { step };
            let own = Path::new(folder).join(name);
            let step = step.word("--out").with(self.written(own.join("tip.parquet")));
            let (title, about) = if has_network {
                ("predict", "the calibrated twin follows strokes that it has not learned from")
            } else {
                ("predict-without", "the same without the network, to compare")
            };
            self.stage(&format!("{title} {name}"), own, about, step, PER_SIMULATED * n as f64)
        };
        let checks = &self.study.plan.checks;
        checks
            .iter()
            .flat_map(|(name, n)| [stage(name, *n, PREDICTED[0], true), stage(name, *n, PREDICTED[1], false)])
            .collect()
    }

    fn generate(&self) -> Option<Stage> {
        let plan = self.study.generate.as_ref()?;
        let step = step("generate").with(self.scene()).word("--residual").with(self.checkpoint());
        let step = step.word("--plan").with(plan.argument.clone()).word("--real").with(self.made(DATA));
        let step = step.word("--out").with(self.written("generated"));
        let about = "the calibrated twin makes more recordings, of motions that the rig never did";
        let guess = PER_SIMULATED * Self::samples(&plan.training);
        let stage = self.stage("generate", "generated", about, step, guess);
        Some(Stage { restart: Restart::GoesOn, ..stage })
    }

    fn train(&self) -> Option<Stage> {
        let train = self.study.train.as_ref()?;
        let mut step = step("train").with(self.made(DATA));
        let mut n = Self::samples(&self.study.plan.training);
        if let Some(plan) = &self.study.generate {
            step = step.with(self.made("generated"));
            n += Self::samples(&plan.training);
        }
        let step = if self.study.residual.is_some() {
            step.word("--scene").with(self.scene()).word("--residual").with(self.checkpoint())
        } else {
            step
        };
        let step = step
            .option("--epochs", train.epochs)
            .option("--hidden", train.hidden)
            .option("--seed", Some(self.study.seed))
            .word("--out")
            .with(self.written("inverse/network.safetensors"));
        let about = "a network learns which strokes lead the tip along a path";
        let guess = PER_INVERSE_EPOCH * train.epochs.unwrap_or(30) as f64 * n;
        let stage = self.stage("train", "inverse", about, step, guess);
        Some(Stage { restart: Restart::GoesOn, ..stage })
    }

    /// Strokes for a target by one method, run `repeats` times, and measured.
    fn track(&self, track: &Track, target: &Target, method: Method) -> Stage {
        let folder = folder(target, method);
        let step = step("track").word("--rig").with(self.study.rig.argument.clone());
        let step = match method {
            Method::Nominal => step.word("--scene").with(self.nominal_scene()).word("--nominal"),
            Method::Scene => step.word("--scene").with(self.scene()),
            Method::Twin => step.with(self.checkpoint()).word("--scene").with(self.scene()),
            Method::Network => step.with(self.made("inverse/network.safetensors")).word("--network"),
        };
        let step = step
            .word("--target")
            .with(target.argument.clone())
            .option("--repeats", Some(track.repeats))
            // Other noise than in the data.
            .option("--seed", Some(self.study.seed.wrapping_add(1)))
            .word("--out")
            .with(self.written(&folder));
        let on_refusal = if self.study.rig.is_virtual {
            OnRefusal::NoteWith(self.out.join(&folder).join(STROKES))
        } else {
            OnRefusal::Fail
        };
        let led = if method == Method::Network { 0.0 } else { PER_LED };
        let guess = (led + track.repeats as f64 * self.per_recorded()) * target.path.points().len() as f64;
        let name = format!("track {} {}", target.name, method.name());
        let stage = self.stage(&name, folder, &about(target, method), Step { on_refusal, ..step }, guess);
        Stage { restart: Restart::GoesOn, outdated: self.outdated(), ..stage }
    }
}

/// Where a target tracked by one method is, in the folder of the study.
pub fn folder(target: &Target, method: Method) -> PathBuf {
    Path::new(TRACKED).join(&target.name).join(method.name())
}

/// Name of a repeat, numbered from 1.
pub fn repeat(number: usize) -> String {
    format!("repeat-{number}.parquet")
}

fn about(target: &Target, method: Method) -> String {
    let how = match method {
        Method::Nominal => "through the twin without parameters fitted to a robot",
        Method::Scene => "through the twin of the scene",
        Method::Twin => "through the calibrated twin",
        Method::Network => "by the inverse network",
    };
    format!("{}: strokes {how}, run and measured", target.argument.typed)
}
