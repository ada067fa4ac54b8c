//! A policy that is cloned from the expert: its observation, its network and its training.

use hysteron_arm_learning::neural::{LiveEstimator, ServoTelemetry};
use hysteron_base::{BadInput, json};
use hysteron_learn::{
    Activation, Adam, ByParameters, Decay, Mlp, MlpTape, Objective, Schedule, TrainingSession, minimise,
};
use hysteron_virtual_rig::virtual_arm::{N_JOINTS, N_SERVOS, Reading};

use super::trial::MAX_LEAD;

/// Every so many rows of a demonstration are learned from.
const STRIDE: usize = 4;
/// Units of the policy's hidden layers, epochs, samples of a step, step size.
pub(super) const HIDDEN: [usize; 2] = [64, 64];
pub(super) const EPOCHS: usize = 60;
const BATCH: usize = 64;
const RATE: f64 = 2e-3;

/// Observation of a policy in addition to plan and positions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Observed {
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
    pub const ALL: [Self; 5] =
        [Self::Nothing, Self::EstimatedForce, Self::TrueWeight, Self::Currents, Self::ServoErrors];

    /// As tables call it.
    pub fn name(self) -> &'static str {
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

/// Everything that a policy may observe, in SI.
pub(super) struct Senses<'m> {
    estimator: Option<LiveEstimator<'m>>,
    last: Option<[f64; N_SERVOS]>,
}

impl<'m> Senses<'m> {
    pub fn new(estimator: Option<&LiveEstimator<'m>>) -> Self {
        Self { estimator: estimator.cloned(), last: None }
    }

    /// Plan, its change since the last reading, positions; then what `observed` adds.
    pub fn observe(
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
pub(super) struct PolicyStep {
    pub reading: Reading,
    pub planned: [f64; N_SERVOS],
    pub force: [f64; 3],
    pub lead: [f64; N_JOINTS],
}

/// Demonstrations as samples.
#[derive(Debug, Default)]
struct Samples {
    inputs: Vec<f32>,
    leads: Vec<f32>,
}

/// A network whose output is the lead of the goals, with the scales of its inputs and outputs.
#[derive(Debug, Clone)]
pub(super) struct Policy {
    /// The network.
    pub mlp: Mlp,
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

    /// Lead of every joint after this observation [rad].
    pub fn lead(&self, tape: &mut MlpTape<f32>, raw: &[f64]) -> Vec<f64> {
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

/// Clones a policy that observes `observed` from demonstrations, for training and validation.
///
/// # Errors
/// Demonstrations without a lead; those of the training.
pub(super) fn clone_expert(
    estimator: Option<&LiveEstimator<'_>>,
    shown: &[Vec<Vec<PolicyStep>>; 2],
    observed: Observed,
    seed: u64,
) -> anyhow::Result<Policy> {
    let shown = shown.each_ref().map(|set| samples_of(estimator, observed, set));
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
    let mean: Vec<f64> = (0..n).map(|k| shown[0].iter().map(|(raw, _)| raw[k]).sum::<f64>() / rows).collect();
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

/// Observations and leads along demonstrations.
fn samples_of(
    estimator: Option<&LiveEstimator<'_>>,
    observed: Observed,
    demonstrations: &[Vec<PolicyStep>],
) -> Vec<(Vec<f64>, [f64; N_JOINTS])> {
    let mut all = Vec::new();
    for steps in demonstrations {
        let mut senses = Senses::new(estimator);
        for (row, step) in steps.iter().enumerate() {
            let raw = senses.observe(observed, (&step.reading, &step.planned), step.force);
            if row % STRIDE == 0 {
                all.push((raw, step.lead));
            }
        }
    }
    all
}
