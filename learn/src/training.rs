//! Training by epochs: a running mean of the weights, the best of them on data held out, and a file of it all.

use std::path::Path;

use hysteron_base::BadInput;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use crate::tensor_file::TensorFile;
use crate::trainer::{FORMAT, VERSION};
use crate::{Batch, Memory, Network, Result, Trainer};

/// A training that keeps the weights which do best on data held out.
///
/// The weights that are judged and kept are a running mean of those of the trainer, or the trainer's own where no mean
/// is asked for.
#[derive(Debug)]
pub struct Training {
    trainer: Trainer,
    /// The running mean of the weights.
    mean: Option<Network>,
    best: Option<Network>,
    course: Course,
}

/// How far a training is.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Course {
    /// Part of the mean that each step renews; none for no mean.
    pub renewed: Option<f32>,
    /// Epochs done.
    pub epochs: usize,
    /// Epochs done when the best weights were found, and their error.
    pub best: Option<(usize, f64)>,
    /// Of every epoch, the error in training and on data held out; files of older programs have none.
    #[serde(default)]
    pub curve: Vec<[f64; 2]>,
}

impl Course {
    pub fn new(renewed: Option<f32>) -> Self {
        Self { renewed, epochs: 0, best: None, curve: Vec::new() }
    }

    /// Ends an epoch; whether none before did better on data held out.
    pub fn end_epoch(&mut self, training: f64, error: f64) -> bool {
        self.epochs += 1;
        self.curve.push([training, error]);
        let is_best = self.best.is_none_or(|(_, best)| error < best);
        if is_best {
            self.best = Some((self.epochs, error));
        }
        is_best
    }

    /// Whether that many epochs have gone by without a better error.
    pub fn is_stuck(&self, patience: usize) -> bool {
        self.best.is_some_and(|(epoch, _)| self.epochs - epoch >= patience)
    }
}

impl Training {
    /// Before the first step. `renewed` is the part of the running mean that each step renews; none for no mean.
    ///
    /// # Panics
    /// If that part is not in (0, 1].
    pub fn new(trainer: Trainer, renewed: Option<f32>) -> Self {
        assert!(renewed.is_none_or(|part| part > 0.0 && part <= 1.0), "part of the mean: {renewed:?}");
        let mean = renewed.map(|_| trainer.network().clone());
        Self { trainer, mean, best: None, course: Course::new(renewed) }
    }

    /// The step size from the next step on; see [`Trainer::set_learning_rate`].
    pub fn set_learning_rate(&mut self, learning_rate: f64) {
        self.trainer.set_learning_rate(learning_rate);
    }

    /// Derivatives of at most this size become zero from the next step on; see [`Trainer::set_gradient_floor`].
    pub fn set_gradient_floor(&mut self, floor: f32) {
        self.trainer.set_gradient_floor(floor);
    }

    /// One step of training, see [`Trainer::step`].
    ///
    /// # Errors
    /// As there.
    pub fn step(
        &mut self,
        batch: &Batch<'_>,
        memory: &mut Memory,
        loss: impl FnOnce(&[f32], &mut [f32]) -> f64,
    ) -> Result<f64> {
        let value = self.trainer.step(batch, memory, loss)?;
        if let (Some(mean), Some(part)) = (&mut self.mean, self.course.renewed) {
            mean.approach(self.trainer.network(), part);
        }
        Ok(value)
    }

    /// The outputs of the weights that are judged, see [`Trainer::predict`].
    ///
    /// # Errors
    /// As there.
    pub fn predict(&self, batch: &Batch<'_>, memory: &mut Memory) -> Result<Vec<f32>> {
        self.trainer.predict_with(self.network(), batch, memory)
    }

    /// The weights that are judged now.
    pub fn network(&self) -> &Network {
        self.mean.as_ref().unwrap_or(self.trainer.network())
    }

    /// Ends an epoch with the error in training, and that of [`Training::network`] on data held out; keeps the weights if
    /// none did better there.
    pub fn end_epoch(&mut self, training: f64, error: f64) {
        if self.course.end_epoch(training, error) {
            self.best = Some(self.network().clone());
        }
    }

    /// Of every epoch, the error in training and on data held out.
    pub fn curve(&self) -> &[[f64; 2]] {
        &self.course.curve
    }

    /// Epochs done.
    pub fn epochs(&self) -> usize {
        self.course.epochs
    }

    /// The best weights, the epochs done when they were found, and their error; none before the first epoch ends.
    pub fn best(&self) -> Option<(&Network, usize, f64)> {
        let (epoch, error) = self.course.best?;
        Some((self.best.as_ref()?, epoch, error))
    }

    /// Whether that many epochs have gone by without a better error.
    pub fn is_stuck(&self, patience: usize) -> bool {
        self.course.is_stuck(patience)
    }

    /// Writes everything needed to go on from the end of an epoch, with what the caller wants to find beside it.
    ///
    /// # Errors
    /// `File` if the file system refuses.
    pub fn save(&self, path: &Path, details: &Value) -> Result<()> {
        let mut file = TensorFile::default();
        self.trainer.put_into(&mut file);
        file.put("details", details.clone());
        file.put("course", json!(self.course));
        for (prefix, network) in [("mean.", &self.mean), ("best.", &self.best)] {
            if let Some(network) = network {
                file.put_network(prefix, network.architecture(), &network.parameters);
            }
        }
        file.write(path, FORMAT, VERSION)
    }

    /// Goes on from a file by [`Training::save`], bit for bit on the same machine. Also gives the caller's details.
    ///
    /// # Errors
    /// `BadInput` for a file that is not whole, not by [`Training::save`] or of another version.
    pub fn load(path: &Path) -> Result<(Self, Value)> {
        let mut file = TensorFile::read(path, FORMAT, VERSION)?;
        Self::take_from(&mut file).map_err(|error| error.within(path.display()))
    }

    fn take_from(file: &mut TensorFile) -> Result<(Self, Value)> {
        let trainer = Trainer::take_from(file)?;
        let course: Course = file.take("course")?;
        if course.best.is_some_and(|(epoch, _)| epoch > course.epochs) {
            return Err(BadInput::new("course", "a best epoch that is done", format!("{course:?}")).into());
        }
        let mut network = |prefix: &str, is_there: bool| -> Result<Option<Network>> {
            if !is_there {
                return Ok(None);
            }
            let architecture = trainer.network().architecture();
            let parameters = file.take_network(prefix, architecture)?;
            Ok(Some(Network::from_parameters(architecture.clone(), parameters)?))
        };
        let mean = network("mean.", course.renewed.is_some())?;
        let best = network("best.", course.best.is_some())?;
        let details = file.take("details")?;
        Ok((Self { trainer, mean, best, course }, details))
    }
}
