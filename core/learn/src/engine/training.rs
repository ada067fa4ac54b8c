//! A model in training: its optimiser, the exponential moving average of its weights, the best of them on validation data,
//! and a file to resume from. The same for every family.

use std::path::Path;

use hysteron_base::{BadInput, json};
use rayon::prelude::*;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::engine::adam::{CHUNK, Moments, sum_of_squares};
use crate::files::TensorFile;
use crate::{Adam, Float, Result, TrainableModel};

const FORMAT: &str = "hysteron-training";
const VERSION: u64 = 2;

/// A training that keeps the weights which do best on validation data.
///
/// The weights that are evaluated and kept are an exponential moving average of those of the optimiser, or the optimiser's own
/// where none is asked for.
#[derive(Debug)]
pub struct Training<M: TrainableModel> {
    model: M,
    adam: Adam,
    /// Updates done.
    steps: u64,
    /// For each vector of parameters.
    moments: Vec<Moments<M::Value>>,
    /// The moving average.
    average: Option<M>,
    best: Option<M>,
    record: Record,
}

/// State that updates change: parameters, moments and average, one entry for each vector of parameters.
pub(crate) struct Updated<T> {
    /// Updates done.
    pub steps: u64,
    pub parameters: Vec<Vec<T>>,
    pub moments: Vec<Moments<T>>,
    pub average: Option<Vec<Vec<T>>>,
}

/// How far a training is.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Record {
    /// Part of the moving average that each update replaces; none for no average.
    ema: Option<f32>,
    /// Epochs done.
    epochs: usize,
    /// Epochs done when the best weights were found, and their error.
    best: Option<(usize, f64)>,
    /// Of every epoch, the error in training and in validation.
    curve: Vec<[f64; 2]>,
}

impl<M: TrainableModel> Training<M> {
    /// Before the first update. `ema` is the part of the exponential moving average of the weights that each update
    /// replaces, in (0, 1]; none for no average.
    ///
    /// # Errors
    /// `BadInput` for a setting of `adam` or a part out of its range.
    pub fn new(model: M, adam: Adam, ema: Option<f32>) -> Result<Self> {
        adam.check()?;
        if let Some(part) = ema.filter(|part| !(*part > 0.0 && *part <= 1.0)) {
            return Err(BadInput::new("ema", "0 < part <= 1", part.to_string()).into());
        }
        let moments = model.parameters().iter().map(|values| Moments::zeros(values.len())).collect();
        let average = ema.map(|_| model.clone());
        let record = Record { ema, epochs: 0, best: None, curve: Vec::new() };
        Ok(Self { model, adam, steps: 0, moments, average, best: None, record })
    }

    /// The model as the optimiser has it.
    pub fn model(&self) -> &M {
        &self.model
    }

    /// The model that is evaluated: the moving average where there is one.
    pub fn evaluated(&self) -> &M {
        self.average.as_ref().unwrap_or(&self.model)
    }

    /// Updates done.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// The step size from the next update on; negative or not finite values are refused by that update.
    pub fn set_learning_rate(&mut self, learning_rate: f64) {
        self.adam.learning_rate = learning_rate;
    }

    /// One update by a loss and its gradient, one vector for each of the model's, both at [`Training::model`].
    ///
    /// # Errors
    /// `BadInput` for a step size out of range; `NotFinite` if the loss or the gradient is not finite. The weights are then as
    /// before.
    pub fn update<G: AsRef<[M::Value]>>(&mut self, loss: f64, gradients: &[G]) -> Result<()> {
        let Self { model, adam, steps, moments, average, record, .. } = self;
        let gradients: Vec<&[M::Value]> = gradients.iter().map(AsRef::as_ref).collect();
        let parameters = model.parameters_mut();
        let average = average.as_mut().map(TrainableModel::parameters_mut).zip(record.ema);
        // As one task of the pool, for the same reason as in `minimise`.
        rayon::scope(|_| {
            let norm = gradients.iter().map(|values| sum_of_squares(values)).sum::<f64>().sqrt();
            let scale = adam.checked_scale(*steps, loss, norm)?;
            *steps += 1;
            for ((weights, moments), gradient) in parameters.iter_mut().zip(moments).zip(gradients) {
                adam.update(*steps, scale, gradient, weights, moments);
            }
            if let Some((average, part)) = average {
                move_towards(average, parameters, part);
            }
            Ok(())
        })
    }

    /// The optimiser, and its moments for each vector of parameters.
    pub(crate) fn optimiser(&self) -> (&Adam, &[Moments<M::Value>]) {
        (&self.adam, &self.moments)
    }

    /// The moving average, and the part of it that an update replaces.
    pub(crate) fn average(&self) -> Option<(&M, f32)> {
        self.average.as_ref().zip(self.record.ema)
    }

    /// Takes over what updates that were made elsewhere, on a device, have come to.
    pub(crate) fn take_over(&mut self, updated: Updated<M::Value>) {
        self.steps = updated.steps;
        self.model.parameters_mut().clone_from_slice(&updated.parameters);
        self.moments = updated.moments;
        if let (Some(average), Some(values)) = (&mut self.average, updated.average) {
            average.parameters_mut().clone_from_slice(&values);
        }
    }

    /// Ends an epoch with the error in training, and that of [`Training::evaluated`] in validation; keeps the weights if none
    /// did better there.
    pub fn end_epoch(&mut self, training: f64, validation: f64) {
        let Record { epochs, best, curve, .. } = &mut self.record;
        *epochs += 1;
        curve.push([training, validation]);
        if best.is_none_or(|(_, best)| validation < best) {
            *best = Some((*epochs, validation));
            self.best = Some(self.evaluated().clone());
        }
    }

    /// Keeps the weights from before the first epoch, with their error in validation.
    pub fn keep_first(&mut self, validation: f64) {
        self.record.best = Some((0, validation));
        self.best = Some(self.model.clone());
    }

    /// Of every epoch, the error in training and in validation.
    pub fn curve(&self) -> &[[f64; 2]] {
        &self.record.curve
    }

    /// Epochs done.
    pub fn epochs(&self) -> usize {
        self.record.epochs
    }

    /// The best weights, the epochs done when they were found, and their error; none before the first epoch ends.
    pub fn best(&self) -> Option<(&M, usize, f64)> {
        let (epoch, error) = self.record.best?;
        Some((self.best.as_ref()?, epoch, error))
    }

    /// Whether that many epochs have gone by without a better error.
    pub fn is_stuck(&self, patience: usize) -> bool {
        self.record.best.is_some_and(|(epoch, _)| self.record.epochs - epoch >= patience)
    }

    /// Writes everything needed to resume, with the caller's `details`.
    ///
    /// # Errors
    /// `File` if the file system refuses.
    pub fn save(&self, path: &Path, details: &impl Serialize) -> Result<()> {
        let mut file = TensorFile::default();
        file.put("family", json!(M::FAMILY));
        file.put("shape", json!(self.model.shape()));
        file.put("adam", json!(self.adam));
        file.put("steps", json!(self.steps));
        file.put("record", json!(self.record));
        file.put("details", json!(details));
        let tensors = self.model.tensors();
        file.put_tensors("", &tensors, self.model.parameters());
        file.put_tensors("adam.mean.", &tensors, self.moments.iter().map(|m| &m.mean));
        file.put_tensors("adam.square.", &tensors, self.moments.iter().map(|m| &m.square));
        for (prefix, model) in [("average.", &self.average), ("best.", &self.best)] {
            if let Some(model) = model {
                file.put_tensors(prefix, &tensors, model.parameters());
            }
        }
        file.write(path, FORMAT, VERSION)
    }

    /// Goes on from a file by [`Training::save`] of a model of the shape of `like`, bit for bit on the same machine. Also gives
    /// the caller's details.
    ///
    /// # Errors
    /// `BadInput` for a file that is not whole, not by [`Training::save`], of another version, family or shape, or with details of
    /// another type.
    pub fn load<D: DeserializeOwned>(path: &Path, like: &M) -> Result<(Self, D)> {
        let (training, details) = Self::load_if(path, like, |_| Ok(()))?;
        let details = json::from_value(&details).map_err(|error| {
            BadInput::new(format!("{}: details", path.display()), "those of this training", error.to_string())
        })?;
        Ok((training, details))
    }

    /// As [`Training::load`], of a file whose details `accept` does not refuse.
    ///
    /// # Errors
    /// As there; those of `accept`.
    pub(crate) fn load_if(
        path: &Path,
        like: &M,
        accept: impl FnOnce(&Value) -> std::result::Result<(), BadInput>,
    ) -> Result<(Self, Value)> {
        let mut file = TensorFile::read(path, FORMAT, VERSION)?;
        Ok(Self::take_from(&mut file, like, accept).map_err(|bad| bad.within(path.display()))?)
    }

    fn take_from(
        file: &mut TensorFile,
        like: &M,
        accept: impl FnOnce(&Value) -> std::result::Result<(), BadInput>,
    ) -> std::result::Result<(Self, Value), BadInput> {
        let found: String = file.take("family")?;
        if found != M::FAMILY {
            return Err(BadInput::new("family", M::FAMILY, found).hint("a training of another kind of model"));
        }
        let details = file.take("details")?;
        accept(&details)?;
        let (expected, found): (Value, Value) = (json!(like.shape()), file.take("shape")?);
        if found != expected {
            return Err(BadInput::new("shape", expected.to_string(), found.to_string()));
        }
        let adam: Adam = file.take("adam")?;
        adam.check()?;
        let record: Record = file.take("record")?;
        if let Some((best, _)) = record.best.filter(|(epoch, _)| *epoch > record.epochs) {
            let found = format!("epoch {best} of {} done", record.epochs);
            return Err(BadInput::new("record", "a best epoch that is done", found));
        }
        let steps = file.take("steps")?;
        let tensors = like.tensors();
        let mut vectors = |prefix: &str| file.take_tensors::<M::Value>(prefix, &tensors);
        let moments = vectors("adam.mean.")?.into_iter().zip(vectors("adam.square.")?);
        let moments = moments.map(|(mean, square)| Moments { mean, square }).collect();
        let mut model = |prefix: &str| -> std::result::Result<M, BadInput> {
            let mut model = like.clone();
            model.parameters_mut().clone_from_slice(&vectors(prefix)?);
            Ok(model)
        };
        let average = record.ema.map(|_| model("average.")).transpose()?;
        let best = record.best.map(|_| model("best.")).transpose()?;
        let model = model("")?;
        Ok((Self { model, adam, steps, moments, average, best, record }, details))
    }
}

/// Moves every weight by `part` of the way to that of a model of the same shape.
///
/// # Reference
/// Polyak, Juditsky (1992), Acceleration of stochastic approximation by averaging.
fn move_towards<T: Float>(average: &mut [Vec<T>], parameters: &[Vec<T>], part: f32) {
    let part = T::of(f64::from(part));
    for (own, other) in average.iter_mut().zip(parameters) {
        own.par_chunks_mut(CHUNK).zip(other.par_chunks(CHUNK)).for_each(|(own, other)| {
            for (own, other) in own.iter_mut().zip(other) {
                *own += part * (*other - *own);
            }
        });
    }
}
