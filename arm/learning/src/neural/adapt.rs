//! An actuator for an arm that has changed, from a few trajectories of it.
//!
//! First what changes on arms: friction and damping of the motors, stiffness of the servos, a payload that stays at the tip. These few numbers
//! are found by rollouts with the network in the loop: it corrects the servo that it was trained with, and goes on correcting. Then
//! updates of the network. Either step is kept if it does better on the end of every trajectory, which neither has learned from.

use hysteron_base::{BadInput, Bounds, json};
use hysteron_fit::{Options, Parameter, ParameterScale, minimum};
use hysteron_learn::{Result, TrainingProgress, TrainingSession, TrainingTask, fit};

use super::actuator::NeuralActuator;
use super::closed_loop::ActuatorLoop;
use super::data::{MIN_ROWS, Trajectory};
use super::loss::{LossWeights, wrap};
use super::segment::{Segment, TelemetrySource};
use super::servo::RolloutServo;
use super::simulation::{ArmSimulation, SimulationOptions};
use super::training::{NeuralOptions, NeuralTask};
use hysteron_arm_dynamics::Model;

/// Full step size of the network's updates.
const RATE: f64 = 2e-3;
/// Part of every trajectory that is learned from; the rest chooses.
const LEARNED: f64 = 0.7;
/// Steps of a rollout, and most rollouts of either kind, that find the servo.
const ROLLOUTS: (usize, usize) = (100, 24);
/// Searches for the servo, each from where the last one ended.
const SEARCHES: usize = 3;
/// Least and greatest factor of friction and damping, and of stiffness.
const FACTORS: [[f64; 2]; 2] = [[0.1, 10.0], [0.5, 2.0]];
/// Heaviest payload [kg].
const HEAVIEST: f64 = 1.0;
/// Error from which on one counts by its size [rad].
const BEND: f64 = 0.01;

impl NeuralActuator {
    /// The actuator of a changed arm; what it senses stays.
    ///
    /// # Errors
    /// `BadInput` where there is no servo in the loop, no trajectory or a short one, and for another arm.
    pub fn adapted(
        &self,
        model: &Model,
        trajectories: &[Trajectory],
        (updates, progress): (u64, &mut dyn FnMut(&TrainingProgress) -> bool),
    ) -> Result<Self> {
        let simulation = self.simulation(model)?;
        let Some(servo) = &self.simulation.servo else {
            let expected = "one with a servo in the loop, by --prior servo";
            return Err(BadInput::new("actuator", expected, "one without").into());
        };
        let [training, validation] = halves(trajectories)?;
        let found = self.with_servo(&self.servo_of(model, (servo, &simulation), &training)?);
        let better = [self.clone(), found]
            .into_iter()
            .map(|one| Ok((one.error(model, &validation)?, one)))
            .collect::<Result<Vec<(f64, Self)>>>()?
            .into_iter()
            .min_by(|a, b| a.0.total_cmp(&b.0));
        let start = better.map_or_else(|| self.clone(), |(_, one)| one);
        let (options, simulation) = (options(updates), start.simulation(model)?);
        let mut task = start.task(&options, &simulation, [&training, &validation])?;
        let mut session = TrainingSession { file: None, progress };
        let found = fit(&mut task, start.network.clone(), &json!({}), &mut session)?;
        Ok(Self { network: found.model, ..start })
    }

    fn task<'a>(
        &'a self,
        options: &'a NeuralOptions,
        simulation: &'a ArmSimulation,
        sets: [&'a [Trajectory]; 2],
    ) -> std::result::Result<NeuralTask<'a>, BadInput> {
        NeuralTask::new(options, (simulation, &self.scale, &self.currents), sets)
    }

    /// Root mean square error of the joints on these, half of it in pure simulation [deg].
    fn error(&self, model: &Model, trajectories: &[Trajectory]) -> Result<f64> {
        let (options, simulation) = (options(1), self.simulation(model)?);
        self.task(&options, &simulation, [trajectories, trajectories])?.validate(&self.network)
    }

    fn with_servo(&self, (servo, payload): &(RolloutServo, f64)) -> Self {
        let simulation = SimulationOptions {
            damping: servo.damping,
            servo: Some(servo.clone()),
            payload: *payload,
            ..self.simulation.clone()
        };
        Self { simulation, ..self.clone() }
    }

    /// Servo and payload with which rollouts of this network stay closest to the trajectories.
    fn servo_of(
        &self,
        model: &Model,
        (servo, simulation): (&RolloutServo, &ArmSimulation),
        known: &[Trajectory],
    ) -> std::result::Result<(RolloutServo, f64), BadInput> {
        let n = self.features.joints;
        let horizon = known.iter().map(|one| one.len() - 1).min().unwrap_or(0).min(ROLLOUTS.0);
        let starts = |one: &Trajectory| (0..one.len() - horizon).step_by(horizon.max(1)).collect::<Vec<_>>();
        let all: Vec<(&Trajectory, usize)> =
            known.iter().flat_map(|one| starts(one).into_iter().map(move |start| (one, start))).collect();
        let kinds = [TelemetrySource::Recorded, TelemetrySource::Modelled(&self.currents)];
        let every = all.len().div_ceil(ROLLOUTS.1).max(1);
        let segments: Vec<Segment<'_>> = all
            .iter()
            .step_by(every)
            .flat_map(|(trajectory, start)| {
                kinds.map(|telemetry| Segment { trajectory, start: *start, telemetry })
            })
            .collect();
        let of = |values: &[f64]| {
            let mut changed = servo.clone();
            changed.friction[..n].copy_from_slice(&values[..n]);
            changed.stiffness[..n].copy_from_slice(&values[n..2 * n]);
            changed.damping = values[2 * n];
            (changed, values[2 * n + 1])
        };
        let residuals = |values: &[f64]| -> std::result::Result<Vec<Vec<f64>>, BadInput> {
            let simulation = self.with_servo(&of(values)).simulation(model)?;
            let mut closed = ActuatorLoop::new(
                (&simulation, &self.scale),
                (&self.network, None),
                segments.clone(),
                horizon,
            );
            closed.run(&closed.recorded_start());
            let rows = closed.states().chunks_exact(self.features.state()).enumerate();
            let off = |(i, state): (usize, &[f64])| -> Vec<f64> {
                let Segment { trajectory, start, .. } = segments[i % segments.len()];
                let measured = trajectory.state_at(start + i / segments.len());
                (0..n).map(|k| wrap(state[k] - measured[k])).collect()
            };
            Ok(vec![rows.flat_map(off).collect()])
        };
        let mut values: Vec<f64> = servo.friction[..n].iter().chain(&servo.stiffness[..n]).copied().collect();
        values.extend([servo.damping, simulation.options().payload]);
        let search = Options {
            huber: Some(BEND),
            smallest_effect: 1e-7,
            n_nuisance: 0,
            tolerance: 1e-3,
            watch: &|_, _| true,
        };
        for _ in 0..SEARCHES {
            let parameters: Vec<Parameter> =
                values.iter().enumerate().map(|(k, value)| parameter(k, *value, n)).collect();
            values = minimum(&parameters, &search, residuals)?.0;
        }
        Ok(of(&values))
    }
}

/// Friction of each joint, stiffness of each, damping, payload.
fn parameter(k: usize, start: f64, n: usize) -> Parameter {
    let name = match k {
        k if k < n => format!("friction {}", k + 1),
        k if k < 2 * n => format!("stiffness {}", k + 1 - n),
        k if k == 2 * n => "damping".to_owned(),
        _ => "payload".to_owned(),
    };
    if k > 2 * n {
        let bounds = Bounds { min: 0.0, max: HEAVIEST };
        return Parameter { name, start, bounds, scale: ParameterScale::Linear, prior: None };
    }
    let [least, most] = FACTORS[usize::from((n..2 * n).contains(&k))];
    // A servo may have been found without friction.
    let start = start.max(1e-3);
    let bounds = Bounds { min: least * start, max: most * start };
    Parameter { name, start, bounds, scale: ParameterScale::Logarithmic, prior: None }
}

fn options(updates: u64) -> NeuralOptions {
    let loss = LossWeights {
        position_bend: LossWeights::SERVO_BEND,
        force: 0.0,
        gate: 0.0,
        condition: 0.0,
        ..LossWeights::PUBLISHED
    };
    NeuralOptions {
        horizons: vec![(0, 64)],
        start_noise: 0.0,
        pure: 0.5,
        loss,
        learning_rate: (RATE, (updates / 10).max(1)),
        ema: 0.05,
        epoch: 10,
        ..NeuralOptions::published(0, updates)
    }
}

/// Of every trajectory the part to learn from, and the rest.
fn halves(trajectories: &[Trajectory]) -> std::result::Result<[Vec<Trajectory>; 2], BadInput> {
    if trajectories.is_empty() {
        return Err(BadInput::new("recordings", "one or more", "none"));
    }
    if let Some(short) = trajectories.iter().find(|one| one.len() < 4 * MIN_ROWS) {
        let expected = format!("{} samples or more to adapt to", 4 * MIN_ROWS);
        return Err(BadInput::new(&short.name, expected, short.len().to_string()));
    }
    let at = |one: &Trajectory| (LEARNED * one.len() as f64) as usize;
    let first = trajectories.iter().map(|one| one.rows(0..at(one))).collect();
    let rest = trajectories.iter().map(|one| one.rows(at(one)..one.len())).collect();
    Ok([first, rest])
}
