//! Training of any differentiable model on independent samples, in minibatches.

use hysteron_base::rng;
use rand::RngExt;
use serde::Serialize;

use crate::{
    FitResult, Float, ParameterVector, Result, Schedule, Training, TrainingSession, TrainingTask, fit,
};

/// A mean over training samples that is to be minimised.
pub trait Objective<T>: Send {
    /// Samples of the training data.
    fn n_samples(&self) -> usize;

    /// The mean loss over these samples; fills its gradient by the parameters.
    fn gradient(&mut self, parameters: &[T], samples: &[usize], gradient: &mut [T]) -> f64;

    /// Root mean square error on validation data.
    fn validate(&mut self, parameters: &[T]) -> f64;
}

/// An objective in minibatches.
struct Minibatches<'a, T> {
    objective: &'a mut dyn Objective<T>,
    schedule: &'a Schedule,
    seed: u64,
    /// Samples of a batch.
    batch: usize,
    gradient: [Vec<T>; 1],
}

/// Trains `parameters` in minibatches of `batch` samples, or resumes from the session's file; see [`fit`].
///
/// # Errors
/// As [`fit`].
pub fn minimise<T: Float>(
    objective: &mut dyn Objective<T>,
    parameters: Vec<T>,
    (seed, batch): (u64, usize),
    schedule: &Schedule,
    identity: &impl Serialize,
    session: &mut TrainingSession<'_>,
) -> Result<FitResult<ParameterVector<T>>> {
    let gradient = [vec![T::default(); parameters.len()]];
    let mut task = Minibatches { objective, schedule, seed, batch, gradient };
    fit(&mut task, ParameterVector::new(parameters), identity, session)
}

impl<T: Float> TrainingTask<ParameterVector<T>> for Minibatches<'_, T> {
    type Error = crate::Error;

    fn schedule(&self) -> Schedule {
        self.schedule.clone()
    }

    /// All samples once, in the order drawn from seed and epoch.
    fn epoch(
        &mut self,
        training: &mut Training<ParameterVector<T>>,
        on_step: &mut dyn FnMut(usize, usize) -> bool,
    ) -> Result<Option<f64>> {
        let order = shuffled(self.objective.n_samples(), self.seed, training.epochs());
        let (mut sum, of) = (0.0, order.len().div_ceil(self.batch));
        for (done, samples) in order.chunks(self.batch).enumerate() {
            let (objective, gradient) = (&mut *self.objective, &mut self.gradient);
            // As one task of the pool: from outside, every loop over all threads would be a change of threads and back.
            let loss = rayon::scope(|_| {
                let loss = objective.gradient(training.model().values(), samples, &mut gradient[0]);
                training.update(loss, gradient).map(|()| loss)
            })?;
            sum += loss * samples.len() as f64;
            if !on_step(done + 1, of) {
                return Ok(None);
            }
        }
        Ok(Some(sum / order.len() as f64))
    }

    fn validate(&mut self, model: &ParameterVector<T>) -> Result<f64> {
        Ok(self.objective.validate(model.values()))
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

    use std::path::Path;

    use hysteron_base::json;

    use super::*;
    use crate::{Adam, Decay, TrainingProgress};

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
        progress: &mut dyn FnMut(&TrainingProgress) -> bool,
    ) -> Result<FitResult<ParameterVector<f64>>> {
        let adam = Adam { learning_rate: 0.1, ..Adam::default() };
        let decay = Decay::Step { epochs: 20, factor: 0.5 };
        let schedule = Schedule { epochs, patience: epochs, adam, decay, ema: Some(0.5) };
        let identity = json!({ "data": "line" });
        minimise(
            &mut Line,
            vec![0.0, 0.0],
            (3, 7),
            &schedule,
            &identity,
            &mut TrainingSession { file, progress },
        )
    }

    #[test]
    fn a_line_is_found() {
        let found = train(200, None, &mut |_| true).unwrap();
        assert!(found.is_finished && found.validation < 1e-3, "{found:?}");
    }

    #[test]
    fn a_training_resumes_from_its_file_bit_for_bit() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("state");
        let whole = train(30, None, &mut |_| true).unwrap();
        let mut stop =
            |p: &TrainingProgress| !matches!(p, TrainingProgress::Epoch(epoch) if epoch.number == 11);
        assert!(!train(30, Some(&path), &mut stop).unwrap().is_finished);
        assert_eq!(train(30, Some(&path), &mut |_| true).unwrap(), whole);
    }

    #[test]
    fn a_file_of_another_training_or_of_another_shape_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("state");
        train(3, Some(&path), &mut |_| true).unwrap();
        let refusal = |parameters: Vec<f64>, data: &str| {
            let schedule = Schedule {
                epochs: 3,
                patience: 3,
                adam: Adam::default(),
                decay: Decay::Cosine,
                ema: Some(0.5),
            };
            let mut session = TrainingSession { file: Some(&path), progress: &mut |_| true };
            let identity = json!({ "data": data });
            let found = minimise(&mut Line, parameters, (3, 7), &schedule, &identity, &mut session);
            found.unwrap_err().to_string()
        };
        let bad = refusal(vec![0.0; 2], "circle");
        assert!(bad.contains("another one (data)"), "{bad}");
        let bad = refusal(vec![0.0; 3], "line");
        assert!(bad.contains(r#"shape: expected {"parameters":3}, got {"parameters":2}"#), "{bad}");
    }
}
