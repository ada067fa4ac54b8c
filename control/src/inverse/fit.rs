//! What both designs share in training: epochs, the best weights on trajectories held out, and going on from a file.

use std::path::Path;

use hysteron_base::BadInput;
use hysteron_learn::{Adam, Network, Normaliser, Trainer, Training};
use serde_json::{Value, json};

use super::{Dataset, Demonstration, Design, InverseModel, Workspace};
use crate::{Error, Result};

/// What a training reports after an epoch.
#[derive(Debug, Clone, PartialEq)]
pub struct Epoch {
    /// Epochs done, from 1.
    pub number: usize,
    /// Root of the mean loss in training [mm].
    pub training_mm: f64,
    /// Root mean square error of the strokes held out [mm].
    pub held_out_mm: f64,
    /// The best of these so far.
    pub best_mm: f64,
}

/// What a training reports.
#[derive(Debug, Clone, PartialEq)]
pub enum Progress {
    /// A step of Adam.
    Step {
        /// Epochs done.
        epoch: usize,
        /// Steps of this epoch done.
        done: usize,
        /// Steps of an epoch.
        of: usize,
    },
    /// The end of an epoch.
    Epoch(Epoch),
}

/// Where a training stands between runs, and who is told.
pub struct Session<'a> {
    /// File to go on from, written after every epoch; none for no file.
    pub file: Option<&'a Path>,
    /// Gets the progress; ends the training where it returns false. A part of an epoch is then lost.
    pub progress: &'a mut dyn FnMut(&Progress) -> bool,
}

/// A trained controller and how well it does on the trajectories held out.
#[derive(Debug, Clone, PartialEq)]
pub struct Fitted {
    /// With the best weights.
    pub model: InverseModel,
    /// Root mean square error of each stroke [mm].
    pub held_out_mm: Vec<f64>,
    /// The same of the static regression alone.
    pub regression_mm: Vec<f64>,
    /// False where the training was ended before its time and can go on from its file.
    pub is_finished: bool,
}

/// A design in training.
pub(super) trait Lesson {
    /// Epochs at most.
    fn epochs(&self) -> usize;
    /// Epochs without a better error after which it ends.
    fn patience(&self) -> usize;
    /// Settings of Adam in an epoch.
    fn adam(&self, epoch: usize) -> Adam;
    /// Part of the running mean of the weights that each step renews; none for no mean.
    fn renewed(&self) -> Option<f32>;
    /// Goes through all training data once; the mean loss [mm²], or none where `on_step(done, of)` ended it.
    fn train(
        &mut self,
        training: &mut Training,
        epoch: usize,
        on_step: &mut dyn FnMut(usize, usize) -> bool,
    ) -> Result<Option<f64>>;
    /// Mean square error of each stroke held out [mm²].
    fn validate(&self, training: &Training) -> Result<Vec<f64>>;
}

/// The best weights, the epochs after which they were found, and whether the training came to its end.
pub(super) struct Outcome {
    pub network: Network,
    pub epoch: usize,
    /// Root mean square error of each stroke held out [mm].
    pub held_out_mm: Vec<f64>,
    pub is_finished: bool,
}

/// What a controller is made of beside its network.
pub(super) struct Parts {
    pub inputs: Normaliser,
    pub outputs: Normaliser,
    pub design: Design,
    pub workspace: Workspace,
    /// Root mean square error of the static regression for each stroke held out [mm].
    pub regression_mm: Vec<f64>,
}

impl Outcome {
    /// The controller; `identity` is that of the training.
    pub fn into_fitted(self, data: &Dataset, identity: Value, parts: Parts) -> Fitted {
        let Parts { inputs, outputs, design, workspace, regression_mm } = parts;
        let mut training = identity;
        training["epochs"] = json!(self.epoch);
        training["held_out_stroke_rmse_mm"] = json!(self.held_out_mm);
        training["static_regression_stroke_rmse_mm"] = json!(regression_mm);
        let model = InverseModel {
            network: self.network,
            inputs,
            outputs,
            design,
            n_tendons: data.n_tendons,
            step_s: data.step,
            limits: data.limits(),
            workspace,
            robots: data.robots(),
            training,
        };
        Fitted { model, held_out_mm: self.held_out_mm, regression_mm, is_finished: self.is_finished }
    }
}

/// Trains `network`, or goes on from the session's file. `identity` says what is trained on what: a file with another
/// one is refused.
pub(super) fn run(
    lesson: &mut dyn Lesson,
    network: Network,
    seed: u64,
    identity: &Value,
    session: &mut Session<'_>,
) -> Result<Outcome> {
    let mut training = match session.file.filter(|path| path.exists()) {
        Some(path) => resumed(path, identity)?,
        None => Training::new(Trainer::new(network, lesson.adam(0), seed)?, lesson.renewed()),
    };
    let is_over = |training: &Training, lesson: &dyn Lesson| {
        training.epochs() >= lesson.epochs() || training.is_stuck(lesson.patience())
    };
    let mut is_finished = is_over(&training, lesson);
    while !is_finished {
        let epoch = training.epochs();
        training.set_learning_rate(lesson.adam(epoch).learning_rate);
        let mut on_step = |done, of| (session.progress)(&Progress::Step { epoch, done, of });
        let Some(loss) = lesson.train(&mut training, epoch, &mut on_step)? else { break };
        let held_out_mm = mean(&lesson.validate(&training)?).sqrt();
        training.end_epoch(held_out_mm);
        if let Some(path) = session.file {
            training.save(path, identity)?;
        }
        let best_mm = training.best().map_or(held_out_mm, |(_, _, error)| error);
        let report = Epoch { number: epoch + 1, training_mm: loss.sqrt(), held_out_mm, best_mm };
        is_finished = is_over(&training, lesson);
        if !(session.progress)(&Progress::Epoch(report)) {
            break;
        }
    }
    let (network, epoch, _) = training.best().ok_or(Error::NothingTrained)?;
    let network = network.clone();
    // Judged by themselves, not by what the training came to after them.
    let judged = Training::new(Trainer::new(network.clone(), Adam::default(), seed)?, None);
    let held_out_mm = lesson.validate(&judged)?.into_iter().map(f64::sqrt).collect();
    Ok(Outcome { network, epoch, held_out_mm, is_finished })
}

fn resumed(path: &Path, identity: &Value) -> Result<Training> {
    let (training, found) = Training::load(path)?;
    if found == *identity {
        return Ok(training);
    }
    let differing =
        identity.as_object().into_iter().flatten().find(|(key, value)| found.get(key) != Some(value));
    let what = differing.map_or("its settings", |(key, _)| key.as_str());
    Err(BadInput::new(
        path.display().to_string(),
        "the training of this command",
        format!("another one ({what})"),
    )
    .hint("remove it to begin anew")
    .into())
}

/// What is trained on what, for a file to go on from and for the checkpoint.
pub(super) fn identity(design: &str, options: Value, data: &Dataset) -> Value {
    let listed = |all: &[Demonstration]| -> Vec<Value> {
        let entry =
            |one: &Demonstration| json!({ "name": one.name, "sha256": one.hash, "origin": one.origin });
        all.iter().map(entry).collect()
    };
    json!({
        "design": design, "options": options,
        "trained_on": listed(&data.training), "held_out": listed(&data.validation),
    })
}

pub(super) fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}
