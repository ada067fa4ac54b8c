//! `NeuralTask`: the warm start and the closed loop as a task of the engine.

use hysteron_base::{BadInput, parallel, rng};
use hysteron_learn::{
    Adam, Decay, Float, Penalty, Schedule, TapePool, Training, TrainingTask, Transformer, warm_up_cosine,
};
use rand::RngExt;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::closed_loop::{ActuatorLoop, LoopGradient};
use super::current::CurrentModel;
use super::data::Trajectory;
use super::features::InputScale;
use super::loss::{LossParts, LossWeights, Totals, wrap};
use super::segment::{Segment, TelemetrySource};
use super::simulation::ArmSimulation;
use super::warm_start::{self, Stretch, span, torques_of};

/// How an actuator is trained.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NeuralOptions {
    /// Updates on torques by inverse dynamics, before the closed loop.
    pub warm_start: u64,
    /// Poses above this are noise, for the inverse dynamics of the warm start [Hz].
    pub cutoff_hz: f64,
    /// Stretches of an update of the warm start.
    pub stretches: usize,
    /// Updates in the closed loop.
    pub updates: u64,
    /// Rollouts of an update.
    pub rollouts: usize,
    /// From which update in the closed loop on, rollouts have how many steps.
    pub horizons: Vec<(u64, usize)>,
    /// Initial positions are off by up to this, uniformly [rad].
    pub start_noise: f64,
    /// Part of an update's rollouts, and of the error in validation, that is in pure simulation: currents by the model of the drives.
    pub pure: f64,
    /// Weights of the losses.
    pub loss: LossWeights,
    /// Full step size, and updates until it is reached.
    pub learning_rate: (f64, u64),
    /// Part of the weights that a full step takes away, over the step size.
    pub weight_decay: f64,
    /// Part of the moving average of the weights that each update replaces.
    pub ema: f32,
    /// Updates between two validations.
    pub epoch: u64,
    /// Steps of a rollout in validation.
    pub validation_horizon: usize,
    /// Of initial weights, batches and noise.
    pub seed: u64,
}

impl NeuralOptions {
    /// Those of NeuralActuator's release but for its number of updates, with a warm start before.
    pub fn published(warm_start: u64, updates: u64) -> Self {
        Self {
            warm_start,
            cutoff_hz: 6.0,
            stretches: 32,
            updates,
            rollouts: 16,
            horizons: vec![(0, 64), (1000, 128), (3000, 256), (6000, 320), (9000, 500)],
            start_noise: 0.15,
            pure: 0.0,
            loss: LossWeights::PUBLISHED,
            learning_rate: (1e-4, 1000),
            weight_decay: 1e-4,
            ema: 1e-3,
            epoch: 100,
            validation_horizon: 500,
            seed: 0,
        }
    }

    /// # Errors
    /// `BadInput` naming the option that is out of range.
    pub fn check(&self) -> Result<(), BadInput> {
        self.loss.check()?;
        let counts = [
            ("stretches", self.stretches as u64, 1, 4096),
            ("rollouts", self.rollouts as u64, 1, 4096),
            ("epoch", self.epoch, 1, 1_000_000),
            ("updates", self.warm_start.saturating_add(self.updates), 1, 10_000_000),
            ("validation_horizon", self.validation_horizon as u64, 1, 100_000),
        ];
        for (name, value, least, most) in counts {
            if !(least..=most).contains(&value) {
                return Err(BadInput::new(name, format!("{least} to {most}"), value.to_string()));
            }
        }
        if self.horizons.first().is_none_or(|first| first.0 != 0) || self.horizons.iter().any(|h| h.1 == 0) {
            let found = format!("{:?}", self.horizons);
            return Err(BadInput::new("horizons", "one from update 0 on, each of a step or more", found));
        }
        if !(0.0..=1.0).contains(&self.pure) {
            return Err(BadInput::new("pure", "0 to 1", self.pure.to_string()));
        }
        let amounts = [("start_noise", self.start_noise), ("learning_rate", self.learning_rate.0)];
        match amounts.into_iter().find(|(_, value)| !(*value >= 0.0 && value.is_finite())) {
            Some((name, value)) => {
                Err(BadInput::new(name, "a finite number, zero or more", value.to_string()))
            }
            None => Ok(()),
        }
    }

    /// Steps of a rollout in an update of the closed loop.
    pub fn horizon(&self, update: u64) -> usize {
        self.horizons.iter().rev().find(|(from, _)| *from <= update).map_or(1, |(_, horizon)| *horizon)
    }

    fn adam(&self) -> Adam {
        Adam {
            learning_rate: self.learning_rate.0,
            weight_decay: self.weight_decay,
            penalty: Penalty::Decoupled,
            clip_norm: Some(1.0),
            ..Adam::default()
        }
    }
}

/// Rollouts that a thread runs side by side.
pub(super) const GROUP: usize = 8;

/// Training task of an actuator: options, simulation and trajectories.
pub struct NeuralTask<'a> {
    options: &'a NeuralOptions,
    simulation: &'a ArmSimulation,
    scale: &'a InputScale,
    currents: &'a CurrentModel,
    training: &'a [Trajectory],
    validation: &'a [Trajectory],
    /// Of the training trajectories, by inverse dynamics; none with a servo in the loop, whose torque has another form.
    torques: Vec<Vec<f64>>,
    /// Steps of rollouts and samples of the warm start that were simulated, for a throughput.
    pub steps: u64,
    tapes: TapePool<f32>,
}

impl<'a> NeuralTask<'a> {
    /// From trajectories to train on, and others to keep the best weights by.
    ///
    /// # Errors
    /// `BadInput` for an option out of range; where one of both has no trajectory; where filters do not fit.
    pub fn new(
        options: &'a NeuralOptions,
        (simulation, scale, currents): (&'a ArmSimulation, &'a InputScale, &'a CurrentModel),
        [training, validation]: [&'a [Trajectory]; 2],
    ) -> Result<Self, BadInput> {
        options.check()?;
        for (name, part) in [("training", training), ("validation", validation)] {
            if part.is_empty() {
                return Err(BadInput::new(format!("{name} recordings"), "one or more", "none"));
            }
            for one in part {
                simulation.options().check_gain(&one.name, one.position_gain)?;
            }
        }
        let has_torques = options.warm_start > 0 && simulation.options().drive_model().is_none();
        let with_torques = if has_torques { training } else { &[] };
        let torques = with_torques
            .iter()
            .map(|one| torques_of(one, simulation, options.cutoff_hz))
            .collect::<Result<Vec<_>, _>>()?;
        let (steps, tapes) = (0, TapePool::default());
        Ok(Self { options, simulation, scale, currents, training, validation, torques, steps, tapes })
    }

    /// One update of the warm start or the closed loop: its loss and gradient.
    fn gradient(&mut self, network: &Transformer<f32>, update: u64) -> (f64, Vec<Vec<f32>>) {
        if update < self.options.warm_start {
            self.warm_gradient(network, update)
        } else {
            let horizon = self.options.horizon(update - self.options.warm_start);
            let longest = self.training.iter().map(|one| one.len() - 1).max().unwrap_or(1);
            let horizon = horizon.min(longest);
            let segments = self.draw(update, horizon);
            let initial = self.initial(update, &segments);
            self.steps += (segments.len() * horizon) as u64;
            let (setting, on_tapes) = ((self.simulation, self.scale), (network, &self.tapes));
            let (loss, gradient) =
                horizon_gradient(setting, on_tapes, &segments, (&initial, horizon), &self.options.loss);
            (loss.loss.sum(), gradient)
        }
    }

    /// Beginnings of rollouts, among trajectories that are long enough.
    fn draw(&self, update: u64, horizon: usize) -> Vec<Segment<'a>> {
        let mut stream = rng(self.options.seed, &format!("neural/rollouts/{update}"));
        let long: Vec<&Trajectory> = self.training.iter().filter(|one| one.len() > horizon).collect();
        let n_pure = (self.options.pure * self.options.rollouts as f64).round() as usize;
        (0..self.options.rollouts)
            .map(|row| {
                let trajectory = long[stream.random_range(0..long.len())];
                let start = stream.random_range(0..trajectory.len() - horizon);
                Segment { trajectory, start, telemetry: self.telemetry(row < n_pure) }
            })
            .collect()
    }

    fn telemetry(&self, is_pure: bool) -> TelemetrySource<'a> {
        if is_pure { TelemetrySource::Modelled(self.currents) } else { TelemetrySource::Recorded }
    }

    /// Recorded states with noise on the joints' positions, all trajectories one after the other.
    fn initial(&self, update: u64, segments: &[Segment<'_>]) -> Vec<f64> {
        let mut stream = rng(self.options.seed, &format!("neural/noise/{update}"));
        let (n, noise) = (self.simulation.features().joints, self.options.start_noise);
        let mut all = Vec::new();
        for segment in segments {
            let mut state = segment.trajectory.state_at(segment.start).to_vec();
            for q in &mut state[..n] {
                *q += noise * stream.random_range(-1.0..=1.0);
            }
            all.extend(state);
        }
        all
    }

    fn warm_gradient(&mut self, network: &Transformer<f32>, update: u64) -> (f64, Vec<Vec<f32>>) {
        let span = span(network.shape().form);
        let mut stream = rng(self.options.seed, &format!("neural/stretches/{update}"));
        let stretches: Vec<Stretch<'_>> = (0..self.options.stretches)
            .map(|_| {
                let which = stream.random_range(0..self.training.len());
                let trajectory = &self.training[which];
                let start = stream.random_range(0..trajectory.len() - span);
                Stretch { trajectory, torques: self.torques.get(which).map(Vec::as_slice), start }
            })
            .collect();
        let segments: Vec<Segment<'_>> =
            stretches.iter().map(|one| Segment::recorded(one.trajectory, one.start)).collect();
        let totals = Totals::of(&segments, span);
        let n_torques = totals.poses * self.simulation.features().motors() as f64;
        let found: Vec<_> = stretches
            .par_chunks(GROUP)
            .map(|group| {
                let mut gradient = self.tapes.zeros(network);
                let about = (&self.options.loss, &totals, n_torques);
                let setting = (self.simulation, self.scale);
                let (parts, torques) =
                    warm_start::gradient((network, &self.tapes), setting, group, about, &mut gradient);
                (parts.sum() + torques, gradient)
            })
            .collect();
        self.steps += (self.options.stretches * span) as u64;
        let loss = found.iter().map(|(loss, _)| loss).sum();
        (loss, self.tapes.sum(found.into_iter().map(|(_, gradient)| gradient)))
    }
}

/// The loss of rollouts of `horizon` steps from `initial`, and its gradient by the network's parameters; on all threads, the same bytes
/// on any number of them.
///
/// # Panics
/// Without segments, or where a trajectory ends before the horizon.
pub fn horizon_gradient<T: Float>(
    (simulation, scale): (&ArmSimulation, &InputScale),
    (network, tapes): (&Transformer<T>, &TapePool<T>),
    segments: &[Segment<'_>],
    (initial, horizon): (&[f64], usize),
    weights: &LossWeights,
) -> (LoopGradient, Vec<Vec<T>>) {
    let totals = Totals::of(segments, horizon);
    let width = simulation.features().state();
    let found: Vec<(LoopGradient, Vec<Vec<T>>)> = segments
        .par_chunks(GROUP)
        .zip(initial.par_chunks(GROUP * width))
        .map(|(segments, initial)| {
            let network_on = (network, Some(tapes));
            let mut closed = ActuatorLoop::new((simulation, scale), network_on, segments.to_vec(), horizon);
            closed.run(initial);
            let mut gradient = tapes.zeros(network);
            (closed.pull_back(weights, &totals, &mut gradient), gradient)
        })
        .collect();
    let mut whole = LoopGradient { loss: LossParts::default(), initial: Vec::new(), torque: 0.0 };
    let n_groups = found.len() as f64;
    let mut gradients = Vec::new();
    for (part, gradient) in found {
        whole.loss.add(&part.loss);
        whole.initial.extend(part.initial);
        whole.torque += part.torque / n_groups;
        gradients.push(gradient);
    }
    (whole, tapes.sum(gradients))
}

impl TrainingTask<Transformer<f32>> for NeuralTask<'_> {
    type Error = hysteron_learn::Error;

    fn schedule(&self) -> Schedule {
        let updates = self.options.warm_start + self.options.updates;
        let epochs = updates.div_ceil(self.options.epoch) as usize;
        let adam = self.options.adam();
        Schedule { epochs, patience: epochs, adam, decay: Decay::Cosine, ema: Some(self.options.ema) }
    }

    /// With a servo in the loop a network without torque is that servo: the weights that are kept are no worse in validation.
    fn keeps_the_first(&self) -> bool {
        self.simulation.options().drive_model().is_some()
    }

    fn epoch(
        &mut self,
        training: &mut Training<Transformer<f32>>,
        on_step: &mut dyn FnMut(usize, usize) -> bool,
    ) -> hysteron_learn::Result<Option<f64>> {
        let of = self.options.warm_start + self.options.updates;
        let first = training.steps();
        let n = self.options.epoch.min(of - first);
        let (full, warm_up) = self.options.learning_rate;
        let mut sum = 0.0;
        for update in first..first + n {
            training.set_learning_rate(full * warm_up_cosine(update, warm_up, of));
            let (loss, gradient) = self.gradient(training.model(), update);
            training.update(loss, &gradient)?;
            self.tapes.give_back(gradient);
            sum += loss;
            if !on_step((update + 1 - first) as usize, n as usize) {
                return Ok(None);
            }
        }
        Ok(Some(sum / n.max(1) as f64))
    }

    /// Root mean square error of the joints in rollouts from the beginning of each validation trajectory [deg].
    fn validate(&mut self, model: &Transformer<f32>) -> hysteron_learn::Result<f64> {
        let n = self.simulation.features().joints;
        let one = |trajectory: &Trajectory, telemetry: TelemetrySource<'_>| {
            let horizon = self.options.validation_horizon.min(trajectory.len() - 1);
            let setting = (self.simulation, self.scale);
            let segment = Segment { trajectory, start: 0, telemetry };
            let mut closed = ActuatorLoop::new(setting, (model, None), vec![segment], horizon);
            closed.run(&closed.recorded_start());
            let states = closed.states().chunks_exact(self.simulation.features().state());
            let off = states.enumerate().skip(1).map(|(i, state)| {
                (0..n).map(|k| wrap(state[k] - trajectory.state_at(i)[k]).powi(2)).sum::<f64>() / n as f64
            });
            off.sum::<f64>() / horizon as f64
        };
        let mut mean = 0.0;
        for (is_pure, part) in [(false, 1.0 - self.options.pure), (true, self.options.pure)] {
            if part > 0.0 {
                let telemetry = self.telemetry(is_pure);
                let all = parallel::map(self.validation, |own| one(own, telemetry));
                mean += part * all.iter().sum::<f64>() / all.len() as f64;
            }
        }
        let error = mean.sqrt().to_degrees();
        // A rollout that runs away is worse than any other, and no reason to end a training.
        Ok(if error.is_finite() { error } else { f64::MAX })
    }
}
