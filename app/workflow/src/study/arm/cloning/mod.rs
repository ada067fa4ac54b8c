//! Behaviour cloning with and without a force among the inputs: an object of unknown mass is put in place, or held in place.
//!
//! Demonstrations come from an expert that sees how far the arm is from its plan and leads the goals until it is there. A policy learns the
//! lead from what it observes at the same time. Rows differ in that alone. Trials are the same for every row.

pub mod score;

use hysteron_arm_dynamics::Model;
use hysteron_arm_learning::neural::{LiveEstimator, NeuralActuator, ServoTelemetry};
use hysteron_base::{BadInput, json, rng};
use hysteron_learn::{
    Activation, Adam, ByParameters, Decay, Mlp, MlpTape, Objective, Schedule, TrainingSession, minimise,
};
use hysteron_virtual_rig::virtual_arm::{ArmControl, N_JOINTS, N_SERVOS, Reading, VirtualArm, VirtualLeader};
use nalgebra::Vector3;
use rand::RngExt;
use serde_json::Value;

use super::Options;
use crate::figures::arm_cloning;
use crate::{Context, arm};
use score::{Row, Task};

/// Virtual arm of the study, and the seed that draws the individual, as `hysteron arm generate` has it by default.
const ARM: (&str, u64) = ("open-manipulator-x", 0);
/// Demonstrations of a policy, and of its validation.
const DEMONSTRATIONS: [usize; 2] = [60, 12];
/// Trials of each task.
const TRIALS: usize = 400;
/// Of `--quick`.
const QUICK: ([usize; 2], usize) = ([10, 3], 12);
/// Heaviest object [kg].
const HEAVIEST: f64 = 0.5;
/// How near the tip must be to where the object belongs [m].
const NEAR: f64 = 5e-3;
/// For how long before the end it must be that near [s].
const STAYS: f64 = 2.0;
/// Rate at which the expert's lead follows the error [1/s].
const EXPERT: f64 = 2.5;
/// Furthest that goals lead [rad].
const MAX_LEAD: f64 = 0.25;
/// Every so many rows of a demonstration are learned from.
const STRIDE: usize = 4;
/// Jaws that hold the object [m].
const HELD: f64 = 0.0225;
/// Units of the policy's hidden layers, epochs, samples of a step, step size.
const HIDDEN: [usize; 2] = [64, 64];
const EPOCHS: usize = 60;
const BATCH: usize = 64;
const RATE: f64 = 2e-3;

/// Observation of a policy in addition to plan and positions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Observed {
    /// Nothing.
    Nothing,
    /// The force on the tip as an actuator estimates it.
    EstimatedForce,
    /// The weight of the object as only the simulation knows it.
    TrueWeight,
    /// The currents of the motors.
    Currents,
    /// How far the arm is behind its goals.
    ServoErrors,
}

impl Observed {
    const ALL: [Self; 5] =
        [Self::Nothing, Self::EstimatedForce, Self::TrueWeight, Self::Currents, Self::ServoErrors];

    /// As tables call it.
    fn name(self) -> &'static str {
        match self {
            Self::Nothing => "plan and positions",
            Self::EstimatedForce => "with the estimated force",
            Self::TrueWeight => "with the true weight",
            Self::Currents => "with the motors' currents",
            Self::ServoErrors => "with the servos' errors",
        }
    }

    fn len(self) -> usize {
        match self {
            Self::Nothing => 0,
            Self::EstimatedForce | Self::TrueWeight => 3,
            Self::Currents | Self::ServoErrors => N_JOINTS,
        }
    }
}

/// An object to handle.
struct Trial {
    plan: VirtualLeader,
    mass: f64,
    goal: Vector3<f64>,
    name: String,
}

impl Trial {
    fn draw(arm: &VirtualArm, task: Task, set: &str, number: usize) -> Self {
        let name = format!("cloning/{task:?}/{set}/{number}");
        let mut stream = rng(ARM.1, &name);
        let mut about = |centre: [f64; 3], by: f64| {
            Vector3::from_fn(|k, _| centre[k] + by * stream.random_range(-1.0..1.0))
        };
        let mut plan = VirtualLeader::steady(&arm.chain);
        let goal = match task {
            Task::Place => {
                let [from, to] = [-0.09, 0.09].map(|y| about([0.20, y, 0.03], 0.02));
                let (to, pitch) = (Vector3::new(to.x, to.y, 0.03), 0.6);
                let above = Vector3::z() * 0.08;
                plan.reaches(0.0, from + above, pitch, HELD);
                plan.reaches(1.8, 0.5 * (from + to) + 1.3 * above, pitch, HELD);
                plan.reaches(1.6, to + above, pitch, HELD);
                plan.reaches(1.4, to, pitch, HELD);
                to
            }
            Task::Stay => {
                let [from, to] = [[0.22, 0.0, 0.06], [0.23, 0.0, 0.19]].map(|centre| about(centre, 0.025));
                plan.reaches(0.0, from, 0.45, HELD);
                plan.reaches(2.4, to, 0.45, HELD);
                to
            }
        };
        plan.stays(STAYS + 1.0);
        let mass = HEAVIEST * stream.random_range(0.0..1.0);
        Self { plan, mass: mass.max(1e-3), goal, name }
    }

    /// Largest distance from the goal in the last seconds [m].
    fn run(&self, arm: &VirtualArm, control: &mut ArmControl<'_>) -> f64 {
        let weight = [0.0, 0.0, -self.mass * arm.chain.gravity.norm()];
        let mut control = |reading: &Reading, planned: &[f64; N_SERVOS], _| control(reading, planned, weight);
        let moments = arm.handle((&self.plan, self.mass), (ARM.1, &self.name), &mut control);
        let end = self.plan.end() - STAYS;
        moments.iter().filter(|m| m.time >= end).map(|m| (m.tip - self.goal).norm()).fold(0.0, f64::max)
    }
}

/// Leads the goals until the arm is where it is planned to be.
#[derive(Default)]
struct Expert {
    lead: [f64; N_JOINTS],
    last: Option<f64>,
}

impl Expert {
    fn control(&mut self, reading: &Reading, planned: &[f64; N_SERVOS]) -> [f64; N_SERVOS] {
        let passed = reading.time - self.last.replace(reading.time).unwrap_or(reading.time);
        for (k, lead) in self.lead.iter_mut().enumerate() {
            let error = planned[k] - reading.position[k];
            *lead = (*lead + EXPERT * passed * error).clamp(-MAX_LEAD, MAX_LEAD);
        }
        led(planned, &self.lead)
    }
}

fn led(planned: &[f64; N_SERVOS], lead: &[f64]) -> [f64; N_SERVOS] {
    let mut goals = *planned;
    goals.iter_mut().zip(lead).for_each(|(goal, lead)| *goal += lead);
    goals
}

/// Everything that a policy may observe, in SI.
struct Senses<'m> {
    estimator: Option<LiveEstimator<'m>>,
    last: Option<[f64; N_SERVOS]>,
}

impl<'m> Senses<'m> {
    fn new(estimator: Option<&LiveEstimator<'m>>) -> Self {
        Self { estimator: estimator.cloned(), last: None }
    }

    /// Plan, its change since the last reading, positions; then what `observed` adds.
    fn observe(
        &mut self,
        observed: Observed,
        (reading, planned): (&Reading, &[f64; N_SERVOS]),
        force: [f64; 3],
    ) -> Vec<f64> {
        let before = self.last.replace(*planned).unwrap_or(*planned);
        let change = planned.iter().zip(before).map(|(now, before)| now - before);
        let joints = |values: &[f64; N_SERVOS]| values[..N_JOINTS].to_vec();
        let mut all = joints(planned);
        all.extend(change.take(N_JOINTS));
        all.extend(joints(&reading.position));
        match observed {
            Observed::Nothing => {}
            Observed::TrueWeight => all.extend(force),
            Observed::Currents => all.extend(joints(&reading.current)),
            Observed::ServoErrors => {
                let errors = reading.goal.iter().zip(reading.position).map(|(goal, q)| goal - q);
                all.extend(errors.take(N_JOINTS));
            }
            Observed::EstimatedForce => {
                let sample = ServoTelemetry {
                    goal: &reading.goal,
                    position: &reading.position,
                    velocity: &reading.velocity,
                    current: &reading.current,
                    voltage: &reading.voltage,
                    temperature: &reading.temperature,
                    pwm: &reading.pwm,
                    goal_aperture: reading.goal_aperture,
                };
                let now = self.estimator.as_mut().map(|estimator| estimator.update(&sample));
                all.extend(now.map_or([0.0; 3], |now| now.force));
            }
        }
        all
    }
}

/// One reading of a demonstration, and the expert's action at it.
struct Step {
    reading: Reading,
    planned: [f64; N_SERVOS],
    force: [f64; 3],
    lead: [f64; N_JOINTS],
}

/// Demonstrations as samples.
#[derive(Debug, Default)]
struct Samples {
    inputs: Vec<f32>,
    leads: Vec<f32>,
}

/// A network that says how far goals are to lead, and how its inputs and outputs are scaled.
#[derive(Debug, Clone)]
struct Policy {
    mlp: Mlp,
    parameters: Vec<f32>,
    inputs: [Vec<f64>; 2],
    /// Spread of the leads [rad].
    leads: f64,
}

impl Policy {
    fn scaled(&self, raw: &[f64]) -> impl Iterator<Item = f32> {
        let [mean, spread] = &self.inputs;
        raw.iter().zip(mean).zip(spread).map(|((x, mean), spread)| ((x - mean) / spread) as f32)
    }

    fn lead(&self, tape: &mut MlpTape<f32>, raw: &[f64]) -> Vec<f64> {
        let inputs: Vec<f32> = self.scaled(raw).collect();
        let most = |y: &f32| (self.leads * f64::from(*y)).clamp(-MAX_LEAD, MAX_LEAD);
        tape.forward(&self.parameters, &inputs).iter().map(most).collect()
    }
}

/// Mean squared error of the leads.
struct Imitation<'a> {
    samples: [&'a Samples; 2],
    tape: MlpTape<f32>,
    n_inputs: usize,
}

impl Imitation<'_> {
    /// Loss over rows, and outputs' gradient.
    fn errors(&mut self, parameters: &[f32], set: usize, rows: &[usize]) -> (f64, Vec<f32>) {
        let (n, m, samples) = (self.n_inputs, N_JOINTS, self.samples[set]);
        let inputs: Vec<f32> = rows.iter().flat_map(|i| &samples.inputs[i * n..][..n]).copied().collect();
        let targets = rows.iter().flat_map(|i| &samples.leads[i * m..][..m]);
        let found = self.tape.forward(parameters, &inputs);
        let per = 1.0 / found.len() as f32;
        let mut loss = 0.0;
        let errors = found.iter().zip(targets).map(|(y, t)| {
            loss += f64::from(per * (y - t) * (y - t));
            2.0 * per * (y - t)
        });
        let errors = errors.collect();
        (loss, errors)
    }
}

impl Objective<f32> for Imitation<'_> {
    fn n_samples(&self) -> usize {
        self.samples[0].leads.len() / N_JOINTS
    }

    fn gradient(&mut self, parameters: &[f32], rows: &[usize], gradient: &mut [f32]) -> f64 {
        let (loss, errors) = self.errors(parameters, 0, rows);
        gradient.fill(0.0);
        self.tape.reverse_parameters(parameters, &errors, ByParameters::Sum(gradient));
        loss
    }

    fn validate(&mut self, parameters: &[f32]) -> f64 {
        let rows: Vec<usize> = (0..self.samples[1].leads.len() / N_JOINTS).collect();
        self.errors(parameters, 1, &rows).0.sqrt()
    }
}

/// Setting of the study, and its size.
struct Study<'a> {
    arm: VirtualArm,
    estimator: Option<LiveEstimator<'a>>,
    demonstrations: [usize; 2],
    trials: usize,
    seeds: u64,
}

/// Carries out the study; `None` where it was interrupted.
pub(super) fn run(options: &Options, context: &Context) -> anyhow::Result<Option<Value>> {
    let actuator = options.actuator.as_deref().map(NeuralActuator::read).transpose()?;
    let model = Model::builtin(ARM.0)?;
    let observed = actuator.as_ref().map(|actuator| actuator.observed_arm(&model)).transpose()?;
    let estimator = match (&actuator, &observed, &options.actuator) {
        (Some(actuator), Some(model), Some(path)) => {
            Some(LiveEstimator::new(actuator, model).map_err(|bad| bad.within(path.display()))?)
        }
        _ => None,
    };
    let (demonstrations, trials) = if options.quick { QUICK } else { (DEMONSTRATIONS, TRIALS) };
    let seeds = if options.quick { 1 } else { options.seeds as u64 };
    let arm = VirtualArm::preset(ARM.0)?.individual(ARM.1);
    let study = Study { arm, estimator, demonstrations, trials, seeds };
    let rows_of = |observed: Observed| observed != Observed::EstimatedForce || study.estimator.is_some();
    let methods: Vec<Observed> = Observed::ALL.into_iter().filter(|it| rows_of(*it)).collect();
    let bar = context.progress("rows", 2 * (methods.len() + 2), 0);
    let mut rows = Vec::new();
    for task in [Task::Place, Task::Stay] {
        let mut add = |name: &str, distances: Vec<f64>, nothing: Option<&[f64]>| {
            bar.inc(1);
            rows.push(Row::of(task, name, (&distances, NEAR), nothing));
            distances
        };
        add("goals as planned", study.every(task, &|_| Box::new(|_, planned, _| *planned)), None);
        let expert = study.every(task, &|_| {
            let mut expert = Expert::default();
            Box::new(move |reading, planned, _| expert.control(reading, planned))
        });
        add("expert", expert, None);
        let shown: Vec<_> =
            (0..study.seeds).map(|seed| [0, 1].map(|set| study.demonstrated(task, seed, set))).collect();
        let mut nothing: Option<Vec<f64>> = None;
        for observed in &methods {
            if context.is_cancelled() {
                return Ok(None);
            }
            let policies = (0..study.seeds)
                .zip(&shown)
                .map(|(seed, shown)| study.learned(shown, *observed, seed))
                .collect::<Result<Vec<_>, _>>()?;
            let distances = study.every(task, &|number| {
                let policy = &policies[number % policies.len()];
                let (mut tape, mut senses) =
                    (MlpTape::new(&policy.mlp), Senses::new(study.estimator.as_ref()));
                Box::new(move |reading, planned, force| {
                    let raw = senses.observe(*observed, (reading, planned), force);
                    led(planned, &policy.lead(&mut tape, &raw))
                })
            });
            let distances = add(observed.name(), distances, nothing.as_deref());
            nothing.get_or_insert(distances);
        }
    }
    bar.finish();
    let about = json!({
        "arm": ARM.0, "demonstrations": study.demonstrations, "trials": study.trials, "policies": study.seeds,
        "near_mm": 1e3 * NEAR, "stays_s": STAYS, "heaviest_kg": HEAVIEST, "hidden": HIDDEN, "epochs": EPOCHS,
    });
    let meta = arm::meta(context, "behaviour cloning with and without a force");
    arm_cloning::write(&options.out, &rows, &about, &meta).map(Some)
}

impl Study<'_> {
    /// Distances of all trials of a task under the controllers that `control` makes for their numbers.
    fn every<'c>(&self, task: Task, control: &dyn Fn(usize) -> Box<ArmControl<'c>>) -> Vec<f64> {
        let one = |number: usize| {
            Trial::draw(&self.arm, task, "test", number).run(&self.arm, &mut *control(number))
        };
        (0..self.trials).map(one).collect()
    }

    /// Steps of the expert, demonstration by demonstration.
    fn demonstrated(&self, task: Task, seed: u64, set: usize) -> Vec<Vec<Step>> {
        let one = |number: usize| {
            let trial = Trial::draw(&self.arm, task, &format!("demonstration-{seed}-{set}"), number);
            let (mut expert, mut steps) = (Expert::default(), Vec::new());
            trial.run(&self.arm, &mut |reading, planned, force| {
                let goals = expert.control(reading, planned);
                steps.push(Step { reading: *reading, planned: *planned, force, lead: expert.lead });
                goals
            });
            steps
        };
        (0..self.demonstrations[set]).map(one).collect()
    }

    /// Observations and leads along demonstrations.
    fn observed(&self, observed: Observed, demonstrations: &[Vec<Step>]) -> Vec<(Vec<f64>, [f64; N_JOINTS])> {
        let mut all = Vec::new();
        for steps in demonstrations {
            let mut senses = Senses::new(self.estimator.as_ref());
            for (row, step) in steps.iter().enumerate() {
                let raw = senses.observe(observed, (&step.reading, &step.planned), step.force);
                if row % STRIDE == 0 {
                    all.push((raw, step.lead));
                }
            }
        }
        all
    }

    fn learned(&self, shown: &[Vec<Vec<Step>>; 2], observed: Observed, seed: u64) -> anyhow::Result<Policy> {
        let shown = shown.each_ref().map(|set| self.observed(observed, set));
        let n = 3 * N_JOINTS + observed.len();
        let mlp = Mlp {
            inputs: n,
            hidden: HIDDEN.to_vec(),
            outputs: N_JOINTS,
            activation: Activation::Tanh,
            skip: false,
        };
        mlp.check()?;
        let rows = shown[0].len() as f64;
        let mean: Vec<f64> =
            (0..n).map(|k| shown[0].iter().map(|(raw, _)| raw[k]).sum::<f64>() / rows).collect();
        let spread = |k: usize| {
            let squares = shown[0].iter().map(|(raw, _)| (raw[k] - mean[k]).powi(2));
            (squares.sum::<f64>() / rows).sqrt().max(1e-3)
        };
        let leads = shown[0].iter().flat_map(|(_, lead)| lead).map(|x| x * x).sum::<f64>();
        let leads = (leads / (rows * N_JOINTS as f64)).sqrt();
        if leads.is_nan() || leads <= 0.0 {
            return Err(BadInput::new("demonstrations", "an expert whose goals lead", "none").into());
        }
        let inputs = [mean.clone(), (0..n).map(spread).collect()];
        let parameters = mlp.initial_parameters(seed, "cloning/policy", 1.0);
        let parameters: Vec<f32> = parameters.into_iter().map(|p| p as f32).collect();
        let mut policy = Policy { mlp: mlp.clone(), parameters: parameters.clone(), inputs, leads };
        let samples = shown.each_ref().map(|shown| Samples {
            inputs: shown.iter().flat_map(|(raw, _)| policy.scaled(raw)).collect(),
            leads: shown.iter().flat_map(|(_, lead)| lead).map(|x| (x / leads) as f32).collect(),
        });
        let mut objective =
            Imitation { samples: [&samples[0], &samples[1]], tape: MlpTape::new(&mlp), n_inputs: n };
        let schedule = Schedule {
            epochs: EPOCHS,
            patience: EPOCHS,
            adam: Adam { learning_rate: RATE, ..Adam::default() },
            decay: Decay::Cosine,
            ema: None,
        };
        let mut session = TrainingSession { file: None, progress: &mut |_| true };
        let found = minimise(&mut objective, parameters, (seed, BATCH), &schedule, &json!({}), &mut session)?;
        policy.parameters = found.model.into_values();
        Ok(policy)
    }
}
