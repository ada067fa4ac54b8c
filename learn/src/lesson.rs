//! Training epoch by epoch, the same for every design: the best weights on data held out, and a file to go on from.

use std::path::Path;

use hysteron_base::BadInput;
use serde_json::Value;

use crate::{Error, Network, Schedule, Trainer, Training};

/// What a training reports after an epoch; errors in the unit of the lesson.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Epoch {
    /// Epochs done, from 1.
    pub number: usize,
    /// Epochs at most.
    pub of: usize,
    /// Root of the mean loss in training.
    pub training: f64,
    /// Root mean square error on data held out.
    pub held_out: f64,
    /// The best of these so far.
    pub best: f64,
}

/// What a training reports.
#[derive(Debug, Clone, Copy, PartialEq)]
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

/// A design in training.
pub trait Lesson {
    /// What can go wrong in it.
    type Error: From<Error>;
    /// The course of its training.
    fn schedule(&self) -> Schedule;
    /// Goes through all training data once; the mean squared loss, or none where `on_step(done, of)` ended it.
    ///
    /// # Errors
    /// Numbers that are not finite.
    fn train(
        &mut self,
        training: &mut Training,
        epoch: usize,
        on_step: &mut dyn FnMut(usize, usize) -> bool,
    ) -> Result<Option<f64>, Self::Error>;
    /// Root mean square error on data held out.
    ///
    /// # Errors
    /// Those of [`Training::predict`].
    fn validate(&mut self, training: &Training) -> Result<f64, Self::Error>;
}

/// What a training came to.
#[derive(Debug, Clone, PartialEq)]
pub struct Learned {
    /// The best weights.
    pub network: Network,
    /// Epochs done when they were found.
    pub epochs: usize,
    /// Their error on data held out.
    pub held_out: f64,
    /// Of every epoch, the error in training and on data held out.
    pub curve: Vec<[f64; 2]>,
    /// False where it was ended before its time and can go on from its file.
    pub is_finished: bool,
}

/// Trains `network`, or goes on from the session's file. `identity` says what is
/// trained on what: a file with another one is refused.
///
/// # Errors
/// Those of the lesson; a file that is damaged, or of another training; [`Error::NothingTrained`].
pub fn teach<L: Lesson>(
    lesson: &mut L,
    network: Network,
    seed: u64,
    identity: &Value,
    session: &mut Session<'_>,
) -> Result<Learned, L::Error> {
    let schedule = lesson.schedule();
    let mut training = match session.file.filter(|path| path.exists()) {
        Some(path) => resumed(path, identity)?,
        None => Training::new(Trainer::new(network, schedule.adam, seed)?, schedule.renewed),
    };
    training.set_gradient_floor(schedule.gradient_floor);
    let is_over =
        |training: &Training| training.epochs() >= schedule.epochs || training.is_stuck(schedule.patience);
    let mut is_finished = is_over(&training);
    while !is_finished {
        let epoch = training.epochs();
        training.set_learning_rate(schedule.learning_rate(epoch));
        let mut on_step = |done, of| (session.progress)(&Progress::Step { epoch, done, of });
        let Some(loss) = lesson.train(&mut training, epoch, &mut on_step)? else { break };
        let held_out = lesson.validate(&training)?;
        training.end_epoch(loss.sqrt(), held_out);
        if let Some(path) = session.file {
            training.save(path, identity)?;
        }
        let best = training.best().map_or(held_out, |(_, _, error)| error);
        let report = Epoch { number: epoch + 1, of: schedule.epochs, training: loss.sqrt(), held_out, best };
        is_finished = is_over(&training);
        if !(session.progress)(&Progress::Epoch(report)) {
            break;
        }
    }
    let (network, epochs, held_out) = training.best().ok_or(Error::NothingTrained)?;
    Ok(Learned { network: network.clone(), epochs, held_out, curve: training.curve().to_vec(), is_finished })
}

fn resumed(path: &Path, identity: &Value) -> crate::Result<Training> {
    let (training, found) = Training::load(path)?;
    check_identity(path, &found, identity)?;
    Ok(training)
}

/// # Errors
/// `BadInput` naming what differs between the training that a file holds and the one that is asked for.
pub(crate) fn check_identity(path: &Path, found: &Value, identity: &Value) -> crate::Result<()> {
    if found == identity {
        return Ok(());
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
