//! Inputs of a network: sequences side by side, and the memory that goes on from one batch to the next.

use hysteron_base::BadInput;

use crate::{Architecture, Result};

/// Where the head is applied.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum HeadOutputs {
    /// After every step: outputs are [step][row][channel].
    All,
    /// After the last step only: outputs are [row][channel].
    Last,
}

/// Sequences of equal length, side by side.
#[derive(Debug, Clone, Copy)]
pub struct SequenceBatch<'a> {
    /// [step][row][channel], steps × rows × inputs.
    pub inputs: &'a [f32],
    /// Samples of each sequence.
    pub steps: usize,
    /// Sequences.
    pub rows: usize,
    /// Where the head is applied.
    pub outputs: HeadOutputs,
}

impl SequenceBatch<'_> {
    /// # Errors
    /// `BadInput` if the array or the memory does not fit.
    pub(crate) fn check(&self, architecture: &Architecture, memory: &Memory) -> Result<()> {
        let expected = self.steps.saturating_mul(self.rows).saturating_mul(architecture.inputs);
        if expected == 0 || self.inputs.len() != expected {
            let shape =
                format!("{} steps × {} rows × {} channels", self.steps, self.rows, architecture.inputs);
            let found = format!("{} values", self.inputs.len());
            return Err(BadInput::new("batch: inputs", shape, found)
                .hint("at least one step and one row")
                .into());
        }
        if let Some(k) = self.inputs.iter().position(|v| !v.is_finite()) {
            let (sample, channel) = (k / architecture.inputs, k % architecture.inputs);
            let [step, row] = [sample / self.rows, sample % self.rows];
            let place = format!("batch: inputs: step {step}, row {row}, channel {channel}");
            return Err(BadInput::new(place, "a finite value", self.inputs[k].to_string()).into());
        }
        let fits = memory.rows == self.rows
            && memory.hidden == architecture.hidden
            && memory.h.len() == architecture.layers;
        if !fits {
            let [layers, hidden] = [architecture.layers, architecture.hidden];
            let expected = format!("{layers} layers × {} rows × {hidden} units", self.rows);
            let found = format!("{} × {} × {}", memory.h.len(), memory.rows, memory.hidden);
            return Err(BadInput::new("memory", expected, found).into());
        }
        Ok(())
    }
}

/// h and c of every layer for every row of the batch.
#[derive(Debug, Clone, PartialEq)]
pub struct Memory {
    pub(crate) rows: usize,
    pub(crate) hidden: usize,
    /// Hidden state of each layer, [row][unit].
    pub(crate) h: Vec<Vec<f32>>,
    /// Cell state of each layer, [row][unit].
    pub(crate) c: Vec<Vec<f32>>,
}

impl Memory {
    /// Nothing remembered.
    pub fn zeros(architecture: &Architecture, rows: usize) -> Self {
        let zeros = vec![vec![0.0; rows * architecture.hidden]; architecture.layers];
        Self { rows, hidden: architecture.hidden, h: zeros.clone(), c: zeros }
    }
}
