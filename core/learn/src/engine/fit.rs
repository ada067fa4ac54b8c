//! Training epoch by epoch, the same for every family of models and every kind of data: a schedule, the best weights on
//! validation data, early stopping, and a file to resume from.

use std::path::Path;

use hysteron_base::{BadInput, json};
use serde::Serialize;
use serde_json::Value;

use crate::{Error, Schedule, TrainableModel, Training};

/// Progress of a training after an epoch; errors in the unit of the task.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Epoch {
    /// Epochs done, from 1.
    pub number: usize,
    /// Epochs at most.
    pub of: usize,
    /// Root of the mean training loss.
    pub training: f64,
    /// Root mean square error in validation.
    pub validation: f64,
    /// The best of these so far.
    pub best: f64,
}

/// Progress of a training: an update or an epoch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum TrainingProgress {
    /// An update of the weights.
    Step {
        /// Epochs done.
        epoch: usize,
        /// Updates of this epoch done.
        done: usize,
        /// Updates of an epoch.
        of: usize,
    },
    /// The end of an epoch.
    Epoch(Epoch),
}

/// Files of a training between runs, and the receiver of its reports.
pub struct TrainingSession<'a> {
    /// File to resume from, written after every epoch; none for no file.
    pub file: Option<&'a Path>,
    /// Gets the progress; ends the training where it returns false. A part of an epoch is then lost.
    pub progress: &'a mut dyn FnMut(&TrainingProgress) -> bool,
}

/// A training task: data, batches and loss.
pub trait TrainingTask<M: TrainableModel> {
    /// Errors of the task.
    type Error: From<Error>;

    /// The optimiser, its step size and the number of epochs.
    fn schedule(&self) -> Schedule;

    /// Whether the model as it comes may be the one that is kept: it is then evaluated before the first epoch.
    fn keeps_the_first(&self) -> bool {
        false
    }

    /// Epochs after which it ends and keeps its weights, without validation data: as many as another training of the same kind
    /// found. None where validation chooses.
    fn ends_after(&self) -> Option<usize> {
        None
    }

    /// Goes through all training data once; the mean squared loss, or none where `on_step(done, of)` ended it.
    ///
    /// # Errors
    /// Numbers that are not finite.
    fn epoch(
        &mut self,
        training: &mut Training<M>,
        on_step: &mut dyn FnMut(usize, usize) -> bool,
    ) -> Result<Option<f64>, Self::Error>;

    /// Root mean square error in validation.
    ///
    /// # Errors
    /// Those of the model's forward pass.
    fn validate(&mut self, model: &M) -> Result<f64, Self::Error>;
}

/// Fit result: the best weights, their error and the learning curve.
#[derive(Debug, Clone, PartialEq)]
pub struct FitResult<M> {
    /// With the best weights.
    pub model: M,
    /// Epochs done when they were found.
    pub epochs: usize,
    /// Their error in validation.
    pub validation: f64,
    /// Of every epoch, the error in training and in validation.
    pub curve: Vec<[f64; 2]>,
    /// False where it was stopped early and can resume from its file.
    pub is_finished: bool,
}

/// Trains `model`, or resumes from the session's file. `identity` describes training and data: a file with
/// another one is refused.
///
/// # Errors
/// Those of the task; a file that is damaged, or of another training; [`Error::NothingTrained`].
pub fn fit<M: TrainableModel, T: TrainingTask<M> + ?Sized>(
    task: &mut T,
    model: M,
    identity: &impl Serialize,
    session: &mut TrainingSession<'_>,
) -> Result<FitResult<M>, T::Error> {
    let identity = &json!(identity);
    let schedule = task.schedule();
    let mut training = match session.file.filter(|path| path.exists()) {
        Some(path) => resumed(path, &model, identity)?,
        None => {
            let mut training = Training::new(model, schedule.adam, schedule.ema)?;
            if task.keeps_the_first() {
                let validation = task.validate(training.evaluated())?;
                training.keep_first(validation);
            }
            training
        }
    };
    let ends_after = task.ends_after();
    let is_over = |training: &Training<M>| match ends_after {
        Some(epochs) => training.epochs() >= epochs,
        None => training.epochs() >= schedule.epochs || training.is_stuck(schedule.patience),
    };
    let mut is_finished = is_over(&training);
    while !is_finished {
        let epoch = training.epochs();
        training.set_learning_rate(schedule.learning_rate(epoch));
        let mut on_step = |done, of| (session.progress)(&TrainingProgress::Step { epoch, done, of });
        let Some(loss) = task.epoch(&mut training, &mut on_step)? else { break };
        let validation = match ends_after {
            Some(_) => f64::NAN,
            None => task.validate(training.evaluated())?,
        };
        training.end_epoch(loss.sqrt(), validation);
        if let Some(path) = session.file {
            training.save(path, identity)?;
        }
        let best = training.best().map_or(validation, |(_, _, error)| error);
        let of = ends_after.unwrap_or(schedule.epochs);
        let report = Epoch { number: epoch + 1, of, training: loss.sqrt(), validation, best };
        is_finished = is_over(&training);
        if !(session.progress)(&TrainingProgress::Epoch(report)) {
            break;
        }
    }
    let last = ends_after.filter(|_| training.epochs() > 0);
    let last = last.map(|_| (training.evaluated(), training.epochs(), f64::NAN));
    let (model, epochs, validation) = last.or_else(|| training.best()).ok_or(Error::NothingTrained)?;
    Ok(FitResult { model: model.clone(), epochs, validation, curve: training.curve().to_vec(), is_finished })
}

fn resumed<M: TrainableModel>(path: &Path, model: &M, identity: &Value) -> crate::Result<Training<M>> {
    Ok(Training::load_if(path, model, |found| check_identity(found, identity))?.0)
}

/// # Errors
/// `BadInput` naming what differs between the training that a file holds and the one that is asked for.
fn check_identity(found: &Value, identity: &Value) -> Result<(), BadInput> {
    if found == identity {
        return Ok(());
    }
    let differing =
        identity.as_object().into_iter().flatten().find(|(key, value)| found.get(key) != Some(value));
    let what = differing.map_or("its settings", |(key, _)| key.as_str());
    Err(BadInput::new("", "the training of this command", format!("another one ({what})"))
        .hint("remove it to begin anew"))
}
