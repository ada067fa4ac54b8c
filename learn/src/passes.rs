//! One pass over whole sequences side by side, as training makes it and as judging does.

use std::ops::Range;

use crate::{Batch, Memory, Outputs, Result, Training};

/// Losses, and how many samples they are of.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Sum {
    /// Sum of the losses.
    pub loss: f64,
    /// Samples.
    pub count: f64,
}

impl Sum {
    /// Mean loss of a sample; zero of none.
    pub fn mean(&self) -> f64 {
        self.loss / f64::max(self.count, 1.0)
    }

    pub(crate) fn add(&mut self, other: Self) {
        self.loss += other.loss;
        self.count += other.count;
    }
}

/// Whole sequences side by side, gone through in pieces, the memory handed on from one to the next.
pub trait Sequences {
    /// Number of sequences.
    fn rows(&self) -> usize;
    /// Samples of the longest.
    fn longest(&self) -> usize;
    /// Inputs of some samples, [step][row][channel]. A sequence that has ended stands still.
    fn inputs(&mut self, samples: Range<usize>) -> Vec<f32>;
    /// Losses where outputs [step][row][channel] begin at sample `start`, none for sequences that have ended; where
    /// asked for, with the gradient of their mean by the outputs, which enters as zeros.
    fn judge(&mut self, start: usize, outputs: &[f32], gradient: Option<&mut [f32]>) -> Sum;
}

fn pieces(longest: usize, piece: usize) -> impl ExactSizeIterator<Item = Range<usize>> {
    (0..longest).step_by(piece).map(move |start| start..longest.min(start + piece))
}

impl Training {
    /// Goes through sequences once, a step for each piece of so many samples. The mean loss, or none where
    /// `on_step(done, of)` ended it.
    ///
    /// # Errors
    /// As [`crate::Trainer::step`].
    pub fn train_sequences(
        &mut self,
        sequences: &mut dyn Sequences,
        piece: usize,
        on_step: &mut dyn FnMut(usize, usize) -> bool,
    ) -> Result<Option<f64>> {
        let rows = sequences.rows();
        let mut memory = Memory::zeros(self.network().architecture(), rows);
        let pieces = pieces(sequences.longest(), piece);
        let (n_steps, mut all) = (pieces.len(), Sum::default());
        for (k, samples) in pieces.enumerate() {
            let inputs = sequences.inputs(samples.clone());
            let batch = Batch { inputs: &inputs, steps: samples.len(), rows, outputs: Outputs::All };
            self.step(&batch, &mut memory, |outputs, gradient| {
                let sum = sequences.judge(samples.start, outputs, Some(gradient));
                all.add(sum);
                sum.mean()
            })?;
            if !on_step(k + 1, n_steps) {
                return Ok(None);
            }
        }
        Ok(Some(all.mean()))
    }

    /// The losses of sequences with the weights that are judged.
    ///
    /// # Errors
    /// As [`crate::Trainer::predict`].
    pub fn judge_sequences(&self, sequences: &mut dyn Sequences, piece: usize) -> Result<Sum> {
        let rows = sequences.rows();
        let mut memory = Memory::zeros(self.network().architecture(), rows);
        let mut all = Sum::default();
        for samples in pieces(sequences.longest(), piece) {
            let inputs = sequences.inputs(samples.clone());
            let batch = Batch { inputs: &inputs, steps: samples.len(), rows, outputs: Outputs::All };
            let outputs = self.predict(&batch, &mut memory)?;
            all.add(sequences.judge(samples.start, &outputs, None));
        }
        Ok(all)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_cover_the_longest_sequence_once() {
        assert_eq!(pieces(5, 2).collect::<Vec<_>>(), [0..2, 2..4, 4..5]);
        assert_eq!(pieces(4, 2).collect::<Vec<_>>(), [0..2, 2..4]);
        assert_eq!(pieces(0, 3).count(), 0);
    }
}
