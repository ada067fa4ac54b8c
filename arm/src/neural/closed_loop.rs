//! The network in a loop with the simulated arm, forward and back through time.
//!
//! Only states and tokens are kept on the way there. On the way back the published form goes through every window again; the
//! streaming form keeps what its tokens were, which is nine times less.

use hysteron_learn::{Form, Real, Transformer, TransformerTape};

use super::data::Trajectory;
use super::features::InputScale;
use super::loss::{Heads, LossParts, LossWeights, Totals};
use super::simulation::Simulation;

/// Where a rollout begins.
#[derive(Debug, Clone, Copy)]
pub struct Segment<'a> {
    /// The trajectory to follow.
    pub trajectory: &'a Trajectory,
    /// Its row with the initial state.
    pub start: usize,
    /// Where its currents, voltages and temperatures come from.
    pub telemetry: Telemetry<'a>,
}

impl<'a> Segment<'a> {
    /// From this row on, with recorded currents.
    pub fn recorded(trajectory: &'a Trajectory, start: usize) -> Self {
        Self { trajectory, start, telemetry: Telemetry::Recorded }
    }

    /// Goals of the motors m at a step of the rollout.
    pub(super) fn goals(&self, step: usize, m: usize) -> &'a [f64] {
        &self.trajectory.inputs_at((self.start + step) as isize)[..m]
    }
}

/// Where currents, voltages and temperatures of a rollout come from.
#[derive(Debug, Clone, Copy)]
pub enum Telemetry<'a> {
    /// The recording, as published: the measured current carries part of the answer.
    Recorded,
    /// A model of the drives says the currents from errors and speeds of the simulation; voltages and temperatures stay as they
    /// were at the beginning. Nothing but goals comes from the recording.
    Modelled(&'a super::rivals::CurrentModel),
}

/// Rollouts side by side, and their gradient.
#[derive(Debug)]
pub struct ClosedLoop<'a, T> {
    simulation: &'a Simulation,
    scale: &'a InputScale,
    network: &'a Transformer<T>,
    segments: Vec<Segment<'a>>,
    horizon: usize,
    /// Steps before the first that the streaming form has seen.
    context: usize,
    tape: TransformerTape<T>,
    /// ((horizon + 1) × trajectories × 2m).
    states: Vec<f64>,
    /// (horizon × trajectories × outputs).
    outputs: Vec<T>,
    /// Of the network (horizon × trajectories × m).
    torques: Vec<f64>,
    tokens: Vec<T>,
}

/// A gradient with what it says of itself.
#[derive(Debug, Clone, Default)]
pub struct LoopGradient {
    /// The loss, part by part.
    pub loss: LossParts,
    /// By the initial states (trajectories × 2m).
    pub initial: Vec<f64>,
    /// Mean length of the gradient by the torques of a step.
    pub torque: f64,
}

impl<'a, T: Real> ClosedLoop<'a, T> {
    /// Rollouts of `horizon` steps along `segments`.
    ///
    /// # Panics
    /// Where a trajectory ends before the horizon.
    pub fn new(
        (simulation, scale): (&'a Simulation, &'a InputScale),
        network: &'a Transformer<T>,
        segments: Vec<Segment<'a>>,
        horizon: usize,
    ) -> Self {
        let shape = network.shape();
        for segment in &segments {
            assert!(
                segment.start + horizon < segment.trajectory.len(),
                "{} ends before",
                segment.trajectory.name
            );
        }
        let rows = segments.len();
        let (context, room) = match shape.form {
            Form::Window => (0, shape.tokens),
            Form::Streaming => (shape.tokens - 1, shape.tokens - 1 + horizon),
        };
        let m = simulation.features().motors();
        Self {
            tape: TransformerTape::new(shape, room, rows),
            states: vec![0.0; (horizon + 1) * rows * 2 * m],
            outputs: vec![T::default(); horizon * rows * shape.outputs()],
            torques: vec![0.0; horizon * rows * m],
            tokens: vec![T::default(); shape.tokens * rows * shape.inputs],
            simulation,
            scale,
            network,
            segments,
            horizon,
            context,
        }
    }

    /// Rollouts side by side.
    fn rows(&self) -> usize {
        self.segments.len()
    }

    /// Recorded states at the segments' beginnings.
    pub fn recorded_start(&self) -> Vec<f64> {
        self.segments.iter().flat_map(|segment| segment.trajectory.state_at(segment.start)).copied().collect()
    }

    /// States from the initial one on ((horizon + 1) × trajectories × 2m).
    pub fn states(&self) -> &[f64] {
        &self.states
    }

    /// Outputs of the network (horizon × trajectories × outputs).
    pub fn outputs(&self) -> &[T] {
        &self.outputs
    }

    fn state(&self, step: usize, row: usize) -> &[f64] {
        let width = self.simulation.features().state();
        &self.states[(step * self.rows() + row) * width..][..width]
    }

    /// Inputs of trajectory `row` at `step` of the rollout in SI; before the first, as recorded.
    fn raw(&self, step: isize, row: usize) -> Vec<f64> {
        let Segment { trajectory, start, telemetry } = self.segments[row];
        let features = self.simulation.features();
        let mut raw = trajectory.inputs_at(start as isize + step).to_vec();
        if step >= 0 {
            features.set_state(self.state(step as usize, row), &mut raw);
            if let Telemetry::Modelled(currents) = telemetry {
                let first = trajectory.inputs_at(start as isize);
                currents.replace(features, first, &mut raw);
            }
        }
        raw
    }

    /// The token of a step as the network gets it, and its derivative by the inputs in SI.
    fn token(&self, step: isize, row: usize, to: &mut [T]) {
        for (k, (to, x)) in to.iter_mut().zip(self.raw(step, row)).enumerate() {
            *to = T::of(self.scale.at(k, x).0);
        }
    }

    /// Steps of the rollout that the tokens of a pass stand for, and the steps of the tape.
    fn pass(&self, step: usize) -> (std::ops::Range<isize>, std::ops::Range<usize>) {
        let tokens = self.network.shape().tokens;
        match self.network.shape().form {
            Form::Window => (step as isize + 1 - tokens as isize..step as isize + 1, 0..tokens),
            Form::Streaming => {
                (step as isize..step as isize + 1, self.context + step..self.context + step + 1)
            }
        }
    }

    /// Runs the network on the tokens of a step.
    fn look(&mut self, steps: std::ops::Range<isize>, on_tape: std::ops::Range<usize>) -> Vec<T> {
        let (rows, width) = (self.rows(), self.network.shape().inputs);
        let mut tokens = std::mem::take(&mut self.tokens);
        let n = steps.len() * rows * width;
        for (k, step) in steps.enumerate() {
            for row in 0..rows {
                self.token(step, row, &mut tokens[(k * rows + row) * width..][..width]);
            }
        }
        let outputs = self.tape.forward(self.network, on_tape, &tokens[..n]).to_vec();
        self.tokens = tokens;
        outputs
    }

    /// Runs all rollouts from `initial` (trajectories × 2m).
    pub fn run(&mut self, initial: &[f64]) {
        let (rows, m) = (self.rows(), self.simulation.features().motors());
        let (width, n) = (rows * 2 * m, self.network.shape().outputs());
        self.states[..width].copy_from_slice(initial);
        for past in 0..self.context {
            self.look(
                past as isize - self.context as isize..past as isize + 1 - self.context as isize,
                past..past + 1,
            );
        }
        for step in 0..self.horizon {
            let (steps, on_tape) = self.pass(step);
            let outputs = self.look(steps, on_tape);
            for row in 0..rows {
                for k in 0..m {
                    let limit = self.simulation.limit(k);
                    self.torques[(step * rows + row) * m + k] =
                        limit * (outputs[row * n + k].to_f64() / limit).tanh();
                }
            }
            self.outputs[step * rows * n..][..rows * n].copy_from_slice(&outputs);
            let (before, after) = self.states.split_at_mut((step + 1) * width);
            let torques = &self.torques[step * rows * m..][..rows * m];
            let goals: Vec<f64> = self.segments.iter().flat_map(|one| one.goals(step, m)).copied().collect();
            self.simulation.step(&before[step * width..], [&goals, torques], &mut after[..width]);
        }
    }

    /// The loss of the rollouts that were run, and its gradient: added to `gradient` by the parameters.
    pub fn pull_back(
        &mut self,
        weights: &LossWeights,
        totals: &Totals,
        gradient: &mut [Vec<T>],
    ) -> LoopGradient {
        let (rows, m) = (self.rows(), self.simulation.features().motors());
        let (width, n) = (rows * 2 * m, self.network.shape().outputs());
        let mut result = LoopGradient::default();
        let mut by_states = vec![0.0; self.states.len()];
        let mut by_outputs = vec![0.0; self.outputs.len()];
        let heads = Heads::new(self.simulation.features());
        for step in 0..self.horizon {
            for row in 0..rows {
                let Segment { trajectory, start, .. } = self.segments[row];
                let at = ((step + 1) * rows + row) * 2 * m;
                let target = start + step + 1;
                let state = &self.states[at..at + 2 * m];
                let by_state = &mut by_states[at..at + 2 * m];
                result.loss.add(&weights.pose(
                    (trajectory, target),
                    self.simulation.features(),
                    state,
                    totals,
                    by_state,
                ));
                let at = (step * rows + row) * n;
                let outputs: Vec<f64> = self.outputs[at..at + n].iter().map(|y| y.to_f64()).collect();
                let by_output = &mut by_outputs[at..at + n];
                result.loss.add(&weights.labels(
                    (trajectory, start + step),
                    &heads,
                    &outputs,
                    totals,
                    by_output,
                ));
            }
        }
        let is_streaming = self.network.shape().form == Form::Streaming;
        self.tape.clear_gradients();
        for step in (0..self.horizon).rev() {
            let states = &self.states[step * width..][..width];
            let torques = self.torques[step * rows * m..][..rows * m].to_vec();
            let goals: Vec<f64> = self.segments.iter().flat_map(|one| one.goals(step, m)).copied().collect();
            let after = &by_states[(step + 1) * width..][..width];
            let [by_before, by_torque] = self.simulation.step_back(states, [&goals, &torques], after);
            by_states[step * width..][..width]
                .iter_mut()
                .zip(&by_before)
                .for_each(|(sum, part)| *sum += part);
            result.torque += by_torque.iter().map(|d| d * d).sum::<f64>().sqrt() / self.horizon as f64;
            let mut by_step = by_outputs[step * rows * n..][..rows * n].to_vec();
            for row in 0..rows {
                for k in 0..m {
                    let share = torques[row * m + k] / self.simulation.limit(k);
                    by_step[row * n + k] += by_torque[row * m + k] * (1.0 - share * share);
                }
            }
            let by_step: Vec<T> = by_step.into_iter().map(T::of).collect();
            let (steps, on_tape) = self.pass(step);
            if !is_streaming {
                self.look(steps.clone(), on_tape.clone());
                self.tape.clear_gradients();
            }
            let by_tokens = self.tape.backward(self.network, on_tape, &by_step, gradient).to_vec();
            self.to_states(steps, &by_tokens, &mut by_states);
            if !is_streaming {
                self.tape.weight_gradients(self.network, self.network.shape().tokens, gradient);
            }
        }
        if is_streaming {
            let nothing = vec![T::default(); self.context * rows * n];
            self.tape.backward(self.network, 0..self.context, &nothing, gradient);
            self.tape.weight_gradients(self.network, self.context + self.horizon, gradient);
        }
        result.initial = by_states[..width].to_vec();
        result
    }

    /// Adds what tokens say to the gradients by the states that they were made from.
    fn to_states(&self, steps: std::ops::Range<isize>, by_tokens: &[T], by_states: &mut [f64]) {
        let (rows, inputs) = (self.rows(), self.network.shape().inputs);
        let features = self.simulation.features();
        let width = features.state();
        for (k, step) in steps.enumerate().filter(|(_, step)| *step >= 0) {
            for row in 0..rows {
                let raw = self.raw(step, row);
                let own = &by_tokens[(k * rows + row) * inputs..][..inputs];
                let mut by_raw: Vec<f64> =
                    own.iter().enumerate().map(|(k, d)| d.to_f64() * self.scale.at(k, raw[k]).1).collect();
                let by_state = &mut by_states[(step as usize * rows + row) * width..][..width];
                if let Telemetry::Modelled(currents) = self.segments[row].telemetry {
                    currents.pull_back(features, &mut by_raw);
                }
                features.state_gradient(&by_raw, by_state);
            }
        }
    }
}
