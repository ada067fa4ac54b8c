//! Training of any differentiable model on independent samples: minibatches of Adam, a schedule, a running mean of the
//! parameters, the best of them on validation data, and a file to go on from.

use std::path::Path;

use hysteron_base::{BadInput, rng};
use rand::RngExt;
use serde_json::{Value, json};

use crate::adam::Moments;
use crate::lesson::{Epoch, Progress, Session, check_identity};
use crate::real::Real;
use crate::tensor_file::TensorFile;
use crate::training::Course;
use crate::{Error, Result, Schedule};

const FORMAT: &str = "hysteron-minimisation";
const VERSION: u64 = 1;

/// A mean over training samples that is to be minimised.
pub trait Objective<T> {
    /// Samples of the training data.
    fn n_samples(&self) -> usize;

    /// The mean loss over these samples; fills its gradient by the parameters.
    fn gradient(&mut self, parameters: &[T], samples: &[usize], gradient: &mut [T]) -> f64;

    /// Root mean square error on validation data.
    fn validate(&mut self, parameters: &[T]) -> f64;
}

/// What a training came to.
#[derive(Debug, Clone, PartialEq)]
pub struct Minimum<T> {
    /// The parameters that do best on validation data.
    pub parameters: Vec<T>,
    /// Epochs done when they were found.
    pub epochs: usize,
    /// Their error on validation data.
    pub validation: f64,
    /// Of every epoch, root of the mean training loss and error on validation data.
    pub curve: Vec<[f64; 2]>,
    /// False where it was ended before its time and can go on from its file.
    pub is_finished: bool,
}

/// All that must be saved to go on.
struct State<T> {
    parameters: Vec<T>,
    /// Running mean; empty where none is asked for.
    mean: Vec<T>,
    best: Vec<T>,
    moments: Moments<T>,
    steps: u64,
    course: Course,
}

/// Trains `parameters` in minibatches of `batch` samples, or goes on from the session's file, bit for bit on the same
/// machine. `identity` says what is trained on what: a file with another one is refused.
///
/// # Errors
/// [`Error::NotFinite`] where loss or gradient are not finite; `BadInput` for a setting out of its range and a file that is
/// damaged or of another training; [`Error::NothingTrained`].
pub fn minimise<T: Real>(
    objective: &mut dyn Objective<T>,
    parameters: Vec<T>,
    (seed, batch): (u64, usize),
    schedule: &Schedule,
    identity: &Value,
    session: &mut Session<'_>,
) -> Result<Minimum<T>> {
    schedule.adam.check()?;
    let mut state = match session.file.filter(|path| path.exists()) {
        Some(path) => State::read(path, parameters.len(), identity)?,
        None => State::new(parameters, schedule.renewed),
    };
    let is_over = |course: &Course| course.epochs >= schedule.epochs || course.is_stuck(schedule.patience);
    let mut is_finished = is_over(&state.course);
    while !is_finished {
        let epoch = state.course.epochs;
        let Some(loss) = state.epoch(objective, (seed, batch), schedule, session)? else { break };
        let validation = objective.validate(state.judged());
        if state.course.end_epoch(loss.sqrt(), validation) {
            state.best = state.judged().to_vec();
        }
        if let Some(path) = session.file {
            state.write(path, identity)?;
        }
        let best = state.course.best.map_or(validation, |(_, error)| error);
        let (number, of, training) = (epoch + 1, schedule.epochs, loss.sqrt());
        is_finished = is_over(&state.course);
        if !(session.progress)(&Progress::Epoch(Epoch { number, of, training, held_out: validation, best })) {
            break;
        }
    }
    let (epochs, validation) = state.course.best.ok_or(Error::NothingTrained)?;
    Ok(Minimum { parameters: state.best, epochs, validation, curve: state.course.curve, is_finished })
}

impl<T: Real> State<T> {
    fn new(parameters: Vec<T>, renewed: Option<f32>) -> Self {
        let mean = renewed.map_or_else(Vec::new, |_| parameters.clone());
        let moments = Moments::zeros(parameters.len());
        Self { parameters, mean, best: Vec::new(), moments, steps: 0, course: Course::new(renewed) }
    }

    /// The parameters that are judged.
    fn judged(&self) -> &[T] {
        if self.mean.is_empty() { &self.parameters } else { &self.mean }
    }

    /// All samples once, in the order that seed and epoch say; the mean loss, or none where it was ended.
    fn epoch(
        &mut self,
        objective: &mut dyn Objective<T>,
        (seed, batch): (u64, usize),
        schedule: &Schedule,
        session: &mut Session<'_>,
    ) -> Result<Option<f64>> {
        let epoch = self.course.epochs;
        let mut adam = schedule.adam;
        adam.learning_rate = schedule.learning_rate(epoch);
        let order = shuffled(objective.n_samples(), seed, epoch);
        let mut gradient = vec![T::default(); self.parameters.len()];
        let (mut sum, of) = (0.0, order.len().div_ceil(batch));
        for (done, samples) in order.chunks(batch).enumerate() {
            let loss = objective.gradient(&self.parameters, samples, &mut gradient);
            self.finite("loss", loss)?;
            let norm = gradient.iter().map(|g| g.to_f64().powi(2)).sum::<f64>().sqrt();
            self.finite("norm of the gradient", norm)?;
            self.steps += 1;
            adam.update(self.steps, adam.scale(norm), &gradient, &mut self.parameters, &mut self.moments);
            let part = T::of(f64::from(self.course.renewed.unwrap_or(1.0)));
            for (mean, p) in self.mean.iter_mut().zip(&self.parameters) {
                *mean += part * (*p - *mean);
            }
            sum += loss * samples.len() as f64;
            if !(session.progress)(&Progress::Step { epoch, done: done + 1, of }) {
                return Ok(None);
            }
        }
        Ok(Some(sum / order.len() as f64))
    }

    fn finite(&self, what: &'static str, value: f64) -> Result<()> {
        if value.is_finite() { Ok(()) } else { Err(Error::NotFinite { step: self.steps, what, value }) }
    }

    fn write(&self, path: &Path, identity: &Value) -> Result<()> {
        let mut file = TensorFile::default();
        file.put("identity", identity.clone());
        file.put("course", json!(self.course));
        file.put("steps", json!(self.steps));
        for (name, values) in self.vectors() {
            file.put_vector(name, values.iter().map(|v| v.to_f64()).collect());
        }
        file.write(path, FORMAT, VERSION)
    }

    fn vectors(&self) -> [(&'static str, &Vec<T>); 5] {
        let Moments { mean, square } = &self.moments;
        [
            ("parameters", &self.parameters),
            ("mean", &self.mean),
            ("best", &self.best),
            ("adam.mean", mean),
            ("adam.square", square),
        ]
    }

    fn read(path: &Path, n_parameters: usize, identity: &Value) -> Result<Self> {
        let mut file = TensorFile::read(path, FORMAT, VERSION)?;
        let within = |bad: BadInput| bad.within(path.display());
        check_identity(path, &file.take("identity").map_err(within)?, identity)?;
        let course: Course = file.take("course").map_err(within)?;
        let steps = file.take("steps").map_err(within)?;
        let mut vector = |name: &str, is_there: bool| -> Result<Vec<T>> {
            let len = if is_there { n_parameters } else { 0 };
            Ok(file.take_vector(name, len).map_err(within)?.into_iter().map(T::of).collect())
        };
        Ok(Self {
            parameters: vector("parameters", true)?,
            mean: vector("mean", course.renewed.is_some())?,
            best: vector("best", course.best.is_some())?,
            moments: Moments { mean: vector("adam.mean", true)?, square: vector("adam.square", true)? },
            steps,
            course,
        })
    }
}

/// 0 … n − 1 in an order that depends on seed and epoch alone.
fn shuffled(n: usize, seed: u64, epoch: usize) -> Vec<usize> {
    let mut rng = rng(seed, &format!("learn/minibatch/{epoch}"));
    let mut order: Vec<usize> = (0..n).collect();
    for i in (1..n).rev() {
        order.swap(i, rng.random_range(0..=i));
    }
    order
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test may stop where it stands

    use super::*;
    use crate::{Adam, Fall};

    /// y = p₀ + p₁ x with samples of p = (1, −2).
    struct Line;

    impl Objective<f64> for Line {
        fn n_samples(&self) -> usize {
            40
        }

        fn gradient(&mut self, p: &[f64], samples: &[usize], gradient: &mut [f64]) -> f64 {
            gradient.fill(0.0);
            let n = samples.len() as f64;
            let mut loss = 0.0;
            for i in samples {
                let x = *i as f64 / 20.0 - 1.0;
                let e = p[0] + p[1] * x - (1.0 - 2.0 * x);
                loss += e * e / n;
                gradient[0] += 2.0 * e / n;
                gradient[1] += 2.0 * e * x / n;
            }
            loss
        }

        fn validate(&mut self, p: &[f64]) -> f64 {
            (p[0] - 1.0).hypot(p[1] + 2.0)
        }
    }

    fn train(
        epochs: usize,
        file: Option<&Path>,
        progress: &mut dyn FnMut(&Progress) -> bool,
    ) -> Result<Minimum<f64>> {
        let adam = Adam { learning_rate: 0.1, ..Adam::default() };
        let fall = Fall::Stairs { epochs: 20, factor: 0.5 };
        let schedule =
            Schedule { epochs, patience: epochs, adam, fall, renewed: Some(0.5), gradient_floor: 0.0 };
        let identity = json!({ "data": "line" });
        minimise(&mut Line, vec![0.0, 0.0], (3, 7), &schedule, &identity, &mut Session { file, progress })
    }

    #[test]
    fn a_line_is_found() {
        let found = train(200, None, &mut |_| true).unwrap();
        assert!(found.is_finished && found.validation < 1e-3, "{found:?}");
    }

    #[test]
    fn a_training_goes_on_from_its_file_bit_for_bit() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("state");
        let whole = train(30, None, &mut |_| true).unwrap();
        let mut stop = |p: &Progress| !matches!(p, Progress::Epoch(epoch) if epoch.number == 11);
        assert!(!train(30, Some(&path), &mut stop).unwrap().is_finished);
        assert_eq!(train(30, Some(&path), &mut |_| true).unwrap(), whole);
    }

    #[test]
    fn a_file_of_another_training_or_a_damaged_one_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("state");
        train(3, Some(&path), &mut |_| true).unwrap();
        let identity = json!({ "data": "circle" });
        let bad = State::<f64>::read(&path, 2, &identity).err().unwrap().to_string();
        assert!(bad.contains("another one (data)"), "{bad}");
        let bad = State::<f64>::read(&path, 3, &json!({ "data": "line" })).err().unwrap().to_string();
        assert!(bad.contains("expected 3 numbers, got 2"), "{bad}");
    }
}
