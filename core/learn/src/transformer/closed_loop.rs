//! A network in a loop with what it drives, forward and back through time.
//!
//! The forward pass keeps states and outputs alone. The backward pass computes windows again; the streaming
//! form keeps its tokens, a window's length less.

use std::ops::Range;

use super::network::Transformer;
use super::shape::TemporalForm;
use super::tape_pool::{PooledTape, TapePool};
use crate::Float;

/// The system that a network drives: some plants of one kind side by side, each with a state, and the
/// network's observations of them.
///
/// `step` counts from the first step of a rollout. Every function has its vector-Jacobian product next to it;
/// those add to their outputs.
pub trait PlantBatch<T> {
    /// Systems side by side (rows).
    fn rows(&self) -> usize;

    /// Numbers of a state.
    fn state_len(&self) -> usize;

    /// Writes the network's observation of a system at a step in this state; before the first step there is a
    /// recording and no state.
    fn observe(&self, row: usize, step: isize, state: Option<&[f64]>, token: &mut [T]);

    /// Adds to `by_state` from the gradient by the token of a step that is not before the first.
    fn observe_back(&self, row: usize, step: usize, state: &[f64], by_token: &[T], by_state: &mut [f64]);

    /// States after a step (rows × state) under the outputs of the network (rows × outputs).
    fn step(&mut self, step: usize, states: &[f64], outputs: &[T], next: &mut [f64]);

    /// Adds to the gradients by `states` and `outputs` from that by the states after the step.
    fn step_back(
        &mut self,
        step: usize,
        at: (&[f64], &[T]),
        by_next: &[f64],
        by_states: &mut [f64],
        by_outputs: &mut [f64],
    );
}

/// The loss of a step: of its number, the row, the state after it and the network's outputs in it; adds to the gradients by these two.
pub type StepLoss<'a> = dyn FnMut((usize, usize), &[f64], &[f64], [&mut [f64]; 2]) + 'a;

/// Rollouts of a network and its plant, and their gradient.
#[derive(Debug)]
pub struct ClosedLoop<'a, P, T> {
    plant: P,
    network: &'a Transformer<T>,
    horizon: usize,
    /// Context of the streaming form: steps before the first.
    context: usize,
    tape: PooledTape<'a, T>,
    /// ((horizon + 1) × rows × state).
    states: Vec<f64>,
    /// (horizon × rows × outputs).
    outputs: Vec<T>,
    tokens: Vec<T>,
}

impl<'a, P: PlantBatch<T>, T: Float> ClosedLoop<'a, P, T> {
    /// Rollouts of `horizon` steps, on a tape from `tapes` where there are any.
    pub fn new(
        plant: P,
        (network, tapes): (&'a Transformer<T>, Option<&'a TapePool<T>>),
        horizon: usize,
    ) -> Self {
        let (shape, rows) = (network.shape(), plant.rows());
        let (context, room) = match shape.form {
            TemporalForm::Window => (0, shape.tokens),
            TemporalForm::Streaming => (shape.tokens - 1, shape.tokens - 1 + horizon),
        };
        Self {
            tape: PooledTape::of(tapes, shape, (room, rows)),
            states: vec![0.0; (horizon + 1) * rows * plant.state_len()],
            outputs: vec![T::default(); horizon * rows * shape.outputs()],
            tokens: vec![T::default(); shape.tokens * rows * shape.inputs],
            plant,
            network,
            horizon,
            context,
        }
    }

    /// The plant that the network drives.
    pub fn plant(&self) -> &P {
        &self.plant
    }

    /// States from the initial one on ((horizon + 1) × rows × state).
    pub fn states(&self) -> &[f64] {
        &self.states
    }

    /// Outputs of the network (horizon × rows × outputs).
    pub fn outputs(&self) -> &[T] {
        &self.outputs
    }

    /// Numbers of all states, and of all outputs, of a step.
    fn widths(&self) -> (usize, usize) {
        let rows = self.plant.rows();
        (rows * self.plant.state_len(), rows * self.network.shape().outputs())
    }

    /// Steps of the rollout for the tokens of a pass, and the steps of the tape.
    fn pass(&self, step: usize) -> (Range<isize>, Range<usize>) {
        let (tokens, now) = (self.network.shape().tokens as isize, step as isize);
        match self.network.shape().form {
            TemporalForm::Window => (now + 1 - tokens..now + 1, 0..self.network.shape().tokens),
            TemporalForm::Streaming => (now..now + 1, self.context + step..self.context + step + 1),
        }
    }

    /// Runs the network on the tokens of these steps; its outputs at the last of them.
    fn run_network(&mut self, steps: Range<isize>, on_tape: Range<usize>) -> &[T] {
        let (rows, inputs) = (self.plant.rows(), self.network.shape().inputs);
        let (width, n) = (self.plant.state_len(), steps.len() * rows * inputs);
        for (k, step) in steps.enumerate() {
            for row in 0..rows {
                let state =
                    (step >= 0).then(|| &self.states[(step as usize * rows + row) * width..][..width]);
                let token = &mut self.tokens[(k * rows + row) * inputs..][..inputs];
                self.plant.observe(row, step, state, token);
            }
        }
        self.tape.forward(self.network, on_tape, &self.tokens[..n])
    }

    /// Runs all rollouts from `initial` (rows × state).
    ///
    /// # Panics
    /// If `initial` is not of that length.
    pub fn run(&mut self, initial: &[f64]) {
        let (width, n) = self.widths();
        self.states[..width].copy_from_slice(initial);
        for past in 0..self.context {
            let step = past as isize - self.context as isize;
            self.run_network(step..step + 1, past..past + 1);
        }
        for step in 0..self.horizon {
            let (steps, on_tape) = self.pass(step);
            let outputs = self.run_network(steps, on_tape).to_vec();
            let (before, after) = self.states.split_at_mut((step + 1) * width);
            self.plant.step(step, &before[step * width..], &outputs, &mut after[..width]);
            self.outputs[step * n..][..n].copy_from_slice(&outputs);
        }
    }

    /// The gradient of a loss along the rollouts that were run: by the initial states (rows × state), and added to `gradient` by the
    /// network's parameters.
    pub fn pull_back(&mut self, loss: &mut StepLoss<'_>, gradient: &mut [Vec<T>]) -> Vec<f64> {
        let (width, n) = self.widths();
        let [mut by_states, mut by_outputs] = self.loss_gradient(loss);
        let is_streaming = self.network.shape().form == TemporalForm::Streaming;
        self.tape.clear_gradients();
        for step in (0..self.horizon).rev() {
            let (before, after) = by_states.split_at_mut((step + 1) * width);
            let by_step = &mut by_outputs[step * n..][..n];
            let at = (&self.states[step * width..][..width], &self.outputs[step * n..][..n]);
            self.plant.step_back(step, at, &after[..width], &mut before[step * width..], by_step);
            let by_step: Vec<T> = by_step.iter().map(|d| T::of(*d)).collect();
            let (steps, on_tape) = self.pass(step);
            if !is_streaming {
                self.run_network(steps.clone(), on_tape.clone());
                self.tape.clear_gradients();
            }
            let by_tokens = self.tape.backward(self.network, on_tape, &by_step, gradient).to_vec();
            self.observe_back(steps, &by_tokens, &mut by_states);
            if !is_streaming {
                self.tape.weight_gradients(self.network, self.network.shape().tokens, gradient);
            }
        }
        if is_streaming {
            let nothing = vec![T::default(); self.context * n];
            self.tape.backward(self.network, 0..self.context, &nothing, gradient);
            self.tape.weight_gradients(self.network, self.context + self.horizon, gradient);
        }
        by_states.truncate(width);
        by_states
    }

    /// The gradient of the losses of all steps by states and outputs, without what one step does to the next.
    fn loss_gradient(&self, loss: &mut StepLoss<'_>) -> [Vec<f64>; 2] {
        let (rows, width, n) = (self.plant.rows(), self.plant.state_len(), self.network.shape().outputs());
        let [mut by_states, mut by_outputs] = [self.states.len(), self.outputs.len()].map(|n| vec![0.0; n]);
        for step in 0..self.horizon {
            for row in 0..rows {
                let state = ((step + 1) * rows + row) * width..((step + 1) * rows + row + 1) * width;
                let output = (step * rows + row) * n..(step * rows + row + 1) * n;
                let outputs: Vec<f64> = self.outputs[output.clone()].iter().map(|y| y.to_f64()).collect();
                let by = [&mut by_states[state.clone()], &mut by_outputs[output]];
                loss((step, row), &self.states[state], &outputs, by);
            }
        }
        [by_states, by_outputs]
    }

    /// Adds the contribution of tokens to the gradients by the states that they were made from.
    fn observe_back(&self, steps: Range<isize>, by_tokens: &[T], by_states: &mut [f64]) {
        let (rows, inputs, width) = (self.plant.rows(), self.network.shape().inputs, self.plant.state_len());
        for (k, step) in steps.enumerate().filter(|(_, step)| *step >= 0) {
            for row in 0..rows {
                let by_token = &by_tokens[(k * rows + row) * inputs..][..inputs];
                let at = (step as usize * rows + row) * width;
                let by_state = &mut by_states[at..at + width];
                self.plant.observe_back(row, step as usize, &self.states[at..at + width], by_token, by_state);
            }
        }
    }
}
