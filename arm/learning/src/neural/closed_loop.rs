//! The network in a loop with the simulated arm, forward and back through time.

use hysteron_learn::{Float, PlantBatch, TapePool, Transformer};

use super::features::InputScale;
use super::heat::WindingTemperatures;
use super::loss::{Heads, LossParts, LossWeights, Totals};
use super::segment::{Segment, TelemetrySource};
use super::simulation::{ArmSimulation, MotorCommand};

/// Arms in simulation along segments of recorded trajectories, side by side.
#[derive(Debug)]
struct SimulatedArms<'a> {
    simulation: &'a ArmSimulation,
    scale: &'a InputScale,
    segments: Vec<Segment<'a>>,
    /// Gains of the rows over that which the servo's stiffness holds for.
    gains: Vec<f64>,
    heat: WindingTemperatures<'a>,
    /// Outputs of the network for each arm, of which the first m are torques before their limit.
    n_outputs: usize,
    /// Of every step that was pulled back, length of the gradient by its torques, last step first.
    torque_gradients: Vec<f64>,
}

/// Rollouts side by side, and their gradient.
#[derive(Debug)]
pub struct ActuatorLoop<'a, T> {
    rollouts: hysteron_learn::ClosedLoop<'a, SimulatedArms<'a>, T>,
}

/// A gradient with its diagnostics.
#[derive(Debug, Clone, Default)]
pub struct LoopGradient {
    /// The loss, part by part.
    pub loss: LossParts,
    /// By the initial states (trajectories × 2m).
    pub initial: Vec<f64>,
    /// Mean length of the gradient by the torques of a step.
    pub torque: f64,
}

impl SimulatedArms<'_> {
    /// Inputs of a row at a step of the rollout in SI; without a state, as recorded.
    fn raw(&self, row: usize, step: isize, state: Option<&[f64]>) -> Vec<f64> {
        let Segment { trajectory, start, telemetry } = self.segments[row];
        let features = self.simulation.features();
        let mut raw = trajectory.inputs_at(start as isize + step).to_vec();
        if let Some(state) = state {
            features.set_state(state, &mut raw);
            if let TelemetrySource::Modelled(currents) = telemetry {
                let first = trajectory.inputs_at(start as isize);
                currents.replace(features, (first, trajectory.gain_over(currents.position_gain)), &mut raw);
            }
        }
        raw
    }

    fn goals(&self, step: usize) -> Vec<f64> {
        let m = self.simulation.features().motors();
        self.segments.iter().flat_map(|one| one.goals(step, m)).copied().collect()
    }

    /// The network's torques from its outputs y: limit · tanh(y/limit).
    fn torques<T: Float>(&self, outputs: &[T]) -> Vec<f64> {
        let m = self.simulation.features().motors();
        let of_row = |row: &[T]| -> Vec<f64> {
            let limited = |(k, y): (usize, &T)| {
                let limit = self.simulation.limit(k);
                limit * (y.to_f64() / limit).tanh()
            };
            row[..m].iter().enumerate().map(limited).collect()
        };
        outputs.chunks_exact(self.n_outputs).flat_map(of_row).collect()
    }
}

impl<T: Float> PlantBatch<T> for SimulatedArms<'_> {
    fn rows(&self) -> usize {
        self.segments.len()
    }

    fn state_len(&self) -> usize {
        self.simulation.features().state()
    }

    fn observe(&self, row: usize, step: isize, state: Option<&[f64]>, token: &mut [T]) {
        for (k, (to, x)) in token.iter_mut().zip(self.raw(row, step, state)).enumerate() {
            *to = T::of(self.scale.at(k, x).0);
        }
    }

    fn observe_back(&self, row: usize, step: usize, state: &[f64], by_token: &[T], by_state: &mut [f64]) {
        let features = self.simulation.features();
        let raw = self.raw(row, step as isize, Some(state));
        let mut by_raw: Vec<f64> =
            by_token.iter().enumerate().map(|(k, d)| d.to_f64() * self.scale.at(k, raw[k]).1).collect();
        if let Segment { trajectory, telemetry: TelemetrySource::Modelled(currents), .. } = self.segments[row]
        {
            currents.pull_back(features, trajectory.gain_over(currents.position_gain), &mut by_raw);
        }
        features.state_gradient(&by_raw, by_state);
    }

    fn step(&mut self, step: usize, states: &[f64], outputs: &[T], next: &mut [f64]) {
        let (goals, torques) = (self.goals(step), self.torques(outputs));
        self.heat.begin(step);
        let windings = self.heat.at(step);
        let command = MotorCommand { goals: &goals, gains: &self.gains, windings, torques: &torques };
        self.simulation.step(states, command, next);
        self.heat.pass(states, [&goals, &self.gains]);
    }

    fn step_back(
        &mut self,
        step: usize,
        (states, outputs): (&[f64], &[T]),
        by_next: &[f64],
        by_states: &mut [f64],
        by_outputs: &mut [f64],
    ) {
        let m = self.simulation.features().motors();
        let (goals, torques) = (self.goals(step), self.torques(outputs));
        let windings = self.heat.at(step);
        let command = MotorCommand { goals: &goals, gains: &self.gains, windings, torques: &torques };
        let [by_before, by_torque] = self.simulation.step_back(states, command, by_next);
        by_states.iter_mut().zip(&by_before).for_each(|(sum, part)| *sum += part);
        self.torque_gradients.push(by_torque.iter().map(|d| d * d).sum::<f64>().sqrt());
        let rows = by_outputs.chunks_exact_mut(self.n_outputs);
        for ((by_output, torques), by_torque) in
            rows.zip(torques.chunks_exact(m)).zip(by_torque.chunks_exact(m))
        {
            for k in 0..m {
                let share = torques[k] / self.simulation.limit(k);
                by_output[k] += by_torque[k] * (1.0 - share * share);
            }
        }
    }
}

impl<'a, T: Float> ActuatorLoop<'a, T> {
    /// Rollouts of `horizon` steps along `segments`, on a tape from `tapes` where there are any.
    ///
    /// # Panics
    /// Where a trajectory ends before the horizon.
    pub fn new(
        (simulation, scale): (&'a ArmSimulation, &'a InputScale),
        (network, tapes): (&'a Transformer<T>, Option<&'a TapePool<T>>),
        segments: Vec<Segment<'a>>,
        horizon: usize,
    ) -> Self {
        for Segment { trajectory, start, .. } in &segments {
            assert!(start + horizon < trajectory.len(), "{} ends before", trajectory.name);
        }
        let n_outputs = network.shape().outputs();
        let known = simulation.options().position_gain();
        let gains = segments.iter().map(|one| one.trajectory.gain_over(known)).collect();
        let heat = WindingTemperatures::new(simulation.options(), simulation.features(), &segments);
        let arms = SimulatedArms {
            simulation,
            scale,
            segments,
            gains,
            heat,
            n_outputs,
            torque_gradients: Vec::new(),
        };
        Self { rollouts: hysteron_learn::ClosedLoop::new(arms, (network, tapes), horizon) }
    }

    /// Recorded states at the segments' beginnings.
    pub fn recorded_start(&self) -> Vec<f64> {
        let segments = self.rollouts.plant().segments.iter();
        segments.flat_map(|segment| segment.trajectory.state_at(segment.start)).copied().collect()
    }

    /// States from the initial one on ((horizon + 1) × trajectories × 2m).
    pub fn states(&self) -> &[f64] {
        self.rollouts.states()
    }

    /// Outputs of the network (horizon × trajectories × outputs).
    pub fn outputs(&self) -> &[T] {
        self.rollouts.outputs()
    }

    /// Runs all rollouts from `initial` (trajectories × 2m).
    pub fn run(&mut self, initial: &[f64]) {
        self.rollouts.run(initial);
    }

    /// The loss of the rollouts that were run, and its gradient: added to `gradient` by the parameters.
    pub fn pull_back(
        &mut self,
        weights: &LossWeights,
        totals: &Totals,
        gradient: &mut [Vec<T>],
    ) -> LoopGradient {
        let SimulatedArms { simulation, segments, .. } = self.rollouts.plant();
        let (features, segments) = (simulation.features(), segments.clone());
        let heads = Heads::new(features);
        let mut parts = LossParts::default();
        let mut loss = |(step, row): (usize, usize), state: &[f64], outputs: &[f64], by: [&mut [f64]; 2]| {
            let Segment { trajectory, start, .. } = segments[row];
            let [by_state, by_outputs] = by;
            parts.add(&weights.pose((trajectory, start + step + 1), features, state, totals, by_state));
            parts.add(&weights.labels((trajectory, start + step), &heads, outputs, totals, by_outputs));
        };
        let initial = self.rollouts.pull_back(&mut loss, gradient);
        let lengths = &self.rollouts.plant().torque_gradients;
        let torque = lengths.iter().fold(0.0, |sum, length| sum + length / lengths.len() as f64);
        LoopGradient { loss: parts, initial, torque }
    }
}
