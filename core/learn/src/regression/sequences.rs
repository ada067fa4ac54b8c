//! Whole sequences side by side: truncated back-propagation through them in training, one pass in validation.

use std::ops::Range;

use hysteron_base::rng;
use rand::RngExt;

use crate::{
    Backprop, Error, HeadOutputs, Memory, Network, Result, Schedule, SequenceBatch, SequenceOptions,
    Training, TrainingTask,
};

/// Losses, and how many samples they are of.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Evaluation {
    /// Sum of the losses.
    pub loss: f64,
    /// Sum of the squared errors of each output, in the unit of the task squared.
    pub squares: Vec<f64>,
    /// Samples.
    pub count: f64,
}

impl Evaluation {
    /// Mean loss of a sample; zero of none.
    pub fn mean(&self) -> f64 {
        self.loss / f64::max(self.count, 1.0)
    }

    /// Mean squared error of each output; zeros of none.
    pub fn mean_squares(&self) -> Vec<f64> {
        self.squares.iter().map(|square| square / f64::max(self.count, 1.0)).collect()
    }

    fn add(&mut self, other: &Self) {
        self.loss += other.loss;
        self.count += other.count;
        self.squares.resize(other.squares.len(), 0.0);
        self.squares.iter_mut().zip(&other.squares).for_each(|(sum, square)| *sum += square);
    }
}

/// Sequences side by side, and the loss of what a network makes of them.
pub trait Sequences {
    /// Number of sequences.
    fn rows(&self) -> usize;
    /// Samples of the longest.
    fn longest(&self) -> usize;
    /// Inputs of some samples, [step][row][channel]. The last sample of a sequence that has ended is repeated. `noise` gives numbers between
    /// -1/2 and 1/2 in training, and zeros in validation.
    fn inputs(&mut self, samples: Range<usize>, noise: &mut dyn FnMut() -> f32) -> Vec<f32>;
    /// Losses where outputs [step][row][channel] begin at sample `start`, none for sequences that have ended; where
    /// asked for, with the gradient of their mean by the outputs, which enters as zeros.
    fn evaluate(&mut self, start: usize, outputs: &[f32], gradient: Option<&mut [f32]>) -> Evaluation;
    /// Root mean square error that the best weights are chosen by.
    fn error(&self, all: &Evaluation) -> f64;
}

/// Ranges of samples between two updates.
fn truncations(longest: usize, length: usize) -> impl ExactSizeIterator<Item = Range<usize>> {
    (0..longest).step_by(length).map(move |start| start..longest.min(start + length))
}

/// A network that learns from whole sequences, which run side by side: an update every so many samples, in order, with the
/// memory handed on.
#[derive(Debug)]
pub struct SequenceTask<'a, S> {
    options: &'a SequenceOptions,
    /// Of the noise: the seed, and the name of its random streams.
    noise: (u64, &'static str),
    passes: Backprop,
    training: S,
    validation: S,
}

impl<'a, S: Sequences> SequenceTask<'a, S> {
    /// Learns from `training`; the best weights are chosen by `validation`. `noise` is the seed of the noise on inputs, and the
    /// name of its random streams.
    ///
    /// # Errors
    /// Options out of range; `Tensors` if a card refuses.
    pub fn new(
        options: &'a SequenceOptions,
        network: &Network,
        noise: (u64, &'static str),
        [training, validation]: [S; 2],
    ) -> Result<Self> {
        options.check()?;
        let passes = Backprop::new(network.architecture(), noise.0)?;
        Ok(Self { options, noise, passes, training, validation })
    }

    /// The sequences that choose the best weights.
    pub fn validation(&self) -> &S {
        &self.validation
    }

    /// Losses in validation.
    ///
    /// # Errors
    /// As [`Backprop::predict`].
    pub fn evaluate(&mut self, network: &Network) -> Result<Evaluation> {
        let sequences = &mut self.validation;
        let rows = sequences.rows();
        let mut memory = Memory::zeros(network.architecture(), rows);
        let mut all = Evaluation::default();
        let network = self.passes.place(network)?;
        for samples in truncations(sequences.longest(), self.options.truncation) {
            let inputs = sequences.inputs(samples.clone(), &mut || 0.0);
            let batch =
                SequenceBatch { inputs: &inputs, steps: samples.len(), rows, outputs: HeadOutputs::All };
            let outputs = network.predict(&batch, &mut memory)?;
            all.add(&sequences.evaluate(samples.start, &outputs, None));
        }
        Ok(all)
    }
}

impl<S: Sequences> TrainingTask<Network> for SequenceTask<'_, S> {
    type Error = Error;

    fn schedule(&self) -> Schedule {
        self.options.schedule()
    }

    fn ends_after(&self) -> Option<usize> {
        self.options.ends_after
    }

    fn epoch(
        &mut self,
        training: &mut Training<Network>,
        on_step: &mut dyn FnMut(usize, usize) -> bool,
    ) -> Result<Option<f64>> {
        let (seed, name) = self.noise;
        let mut stream = rng(seed, &format!("{name}/{}", training.epochs()));
        let mut noise = || stream.random::<f32>() - 0.5;
        let sequences = &mut self.training;
        let rows = sequences.rows();
        let mut memory = Memory::zeros(training.model().architecture(), rows);
        let truncations = truncations(sequences.longest(), self.options.truncation);
        let (n_steps, mut all) = (truncations.len(), Evaluation::default());
        let mut updates = self.passes.updates(training)?;
        for (k, samples) in truncations.enumerate() {
            let inputs = sequences.inputs(samples.clone(), &mut noise);
            let batch =
                SequenceBatch { inputs: &inputs, steps: samples.len(), rows, outputs: HeadOutputs::All };
            updates.step(&batch, &mut memory, |outputs, gradient| {
                let part = sequences.evaluate(samples.start, outputs, Some(gradient));
                all.add(&part);
                part.mean()
            })?;
            if !on_step(k + 1, n_steps) {
                return Ok(None);
            }
        }
        updates.finish()?;
        Ok(Some(all.mean()))
    }

    fn validate(&mut self, network: &Network) -> Result<f64> {
        let all = self.evaluate(network)?;
        Ok(self.validation.error(&all))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn truncations_cover_the_longest_sequence_once() {
        assert_eq!(truncations(5, 2).collect::<Vec<_>>(), [0..2, 2..4, 4..5]);
        assert_eq!(truncations(4, 2).collect::<Vec<_>>(), [0..2, 2..4]);
        assert_eq!(truncations(0, 3).count(), 0);
    }
}
