//! `hysteron arm fit neural`: an actuator from telemetry alone.

use std::path::{Path, PathBuf};
use std::time::Instant;

use hysteron_arm::neural::{
    CurrentModel, Features, Heads, InputScale, LagAndDroop, LossWeights, NeuralActuator, NeuralOptions,
    NeuralTask, Sensing, SensingOptions, SensingTask, ServoModel, Simulation, SimulationOptions, Trajectory,
    Unlabelled, gripper_of, identified_observers, trajectory_of,
};
use hysteron_arm::servo_force::{Observers, observed_arm};
use hysteron_arm::{Model, Recorded};
use hysteron_base::{BadInput, Recording};
use hysteron_learn::{Block, Form, Progress, Session, Transformer, TransformerShape, fit};
use serde_json::{Value, json};

use super::recordings::{Named, Role, files, read};
use crate::resume::Unfinished;
use crate::{Caller, arm};

/// Learn what the motors of an arm do from their telemetry, without torques
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    /// Recordings to learn from, or folders of them
    #[cfg_attr(feature = "clap", arg(required = true, value_name = "REC"))]
    pub recordings: Vec<PathBuf>,
    /// Actuator to write, .safetensors
    #[cfg_attr(feature = "clap", arg(long, value_name = "FILE"))]
    pub out: PathBuf,
    /// The arm: a file of URDF or MJCF, or a built-in name
    #[cfg_attr(feature = "clap", arg(long, value_name = "MODEL", default_value = "open-manipulator-x"))]
    pub model: String,
    /// Do not learn from recordings whose path contains this, as in `weight/pick_place_object_500g`; may be repeated
    #[cfg_attr(feature = "clap", arg(long, value_name = "TEXT"))]
    pub leave_out: Vec<String>,
    /// Recordings whose path contains this move freely: a sample without label of force is one of no force; may be repeated
    #[cfg_attr(feature = "clap", arg(long, value_name = "TEXT", default_value = "force_unlabeled"))]
    pub free: Vec<String>,
    /// streaming (one token a step), or window (all tokens every step, as published)
    #[cfg_attr(feature = "clap", arg(long, value_name = "FORM", default_value = "streaming", value_parser = form))]
    pub form: Form,
    /// released (normalisation first, gated attention, GELU), or printed (equations 4 and 5 of the paper)
    #[cfg_attr(feature = "clap", arg(long, value_name = "LAYERS", default_value = "released", value_parser = block))]
    pub block: Block,
    /// Numbers of a token within the network; the feed-forward networks have twice as many, the heads half
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value_t = 192, value_parser = crate::number::count::<1024>))]
    pub width: usize,
    /// Layers of the network
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value_t = 4, value_parser = crate::number::count::<16>))]
    pub layers: usize,
    /// What moves the simulated motors beside the network: none (as published), or servo (stiffness, friction and damping
    /// identified by rollout, to whose torque the network's is added)
    #[cfg_attr(feature = "clap", arg(long, value_name = "PRIOR", default_value = "none", value_parser = prior))]
    pub prior: Prior,
    /// Updates on torques by inverse dynamics, before the closed loop
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value_t = 2000, value_parser = crate::number::up_to::<1_000_000>))]
    pub warm_start: u32,
    /// Updates in the closed loop
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value_t = 10_000, value_parser = crate::number::up_to::<1_000_000>))]
    pub updates: u32,
    /// Steps of a rollout: these, one after the other, each for an equal part of the updates
    #[cfg_attr(feature = "clap", arg(long, value_name = "N,...", value_delimiter = ',', default_values_t = [64, 128, 256, 320, 500], value_parser = crate::number::count::<100_000>))]
    pub horizons: Vec<usize>,
    /// Rollouts of an update
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value_t = 16, value_parser = crate::number::count::<4096>))]
    pub rollouts: usize,
    /// Where force, contact and condition come from: loop (the network in the loop, as published), or observer (a second network that
    /// sees recorded telemetry with PWM, and the force of a momentum observer that it adds to)
    #[cfg_attr(feature = "clap", arg(long, value_name = "FROM", default_value = "loop", value_parser = sensing))]
    pub sensing: SensingForm,
    /// Updates of that second network
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value_t = 3000, value_parser = crate::number::count::<1_000_000>))]
    pub sensing_updates: usize,
    /// Part of the rollouts, and of the error in validation, in pure simulation: currents by the model of the drives
    #[cfg_attr(feature = "clap", arg(long, value_name = "PART", default_value_t = 0.0))]
    pub pure: f64,
    /// Full step size
    #[cfg_attr(feature = "clap", arg(long, value_name = "RATE", default_value_t = 1e-4))]
    pub learning_rate: f64,
    /// Part of the moving average of the weights that each update replaces
    #[cfg_attr(feature = "clap", arg(long, value_name = "PART", default_value_t = 1e-3))]
    pub ema: f32,
    /// Initial positions of a rollout are off by up to this [rad]
    #[cfg_attr(feature = "clap", arg(long, value_name = "RAD", default_value_t = 0.15))]
    pub start_noise: f64,
    /// A force longer than this is a contact [N]; above the noise of the sensor that labels it
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value_t = 0.01))]
    pub contact_n: f64,
    /// Step of the simulation [s]
    #[cfg_attr(feature = "clap", arg(long, value_name = "S", default_value_t = 0.017))]
    pub period_s: f64,
    /// Of initial weights, batches and noise
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value_t = 0))]
    pub seed: u64,
}

/// What moves the simulated motors beside the network.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Prior {
    /// Nothing, as published.
    None,
    /// A position servo identified by rollout.
    Servo,
}

/// A prior by its name.
///
/// # Errors
/// For another name.
pub fn prior(text: &str) -> Result<Prior, String> {
    match text {
        "none" => Ok(Prior::None),
        "servo" => Ok(Prior::Servo),
        _ => Err("none or servo".to_owned()),
    }
}

/// Where force, contact and condition come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SensingForm {
    /// The network in the loop, as published.
    Loop,
    /// A network of their own, beside a momentum observer.
    Observer,
}

/// Where force, contact and condition come from, by its name.
///
/// # Errors
/// For another name.
pub fn sensing(text: &str) -> Result<SensingForm, String> {
    match text {
        "loop" => Ok(SensingForm::Loop),
        "observer" => Ok(SensingForm::Observer),
        _ => Err("loop or observer".to_owned()),
    }
}

/// A form by its name.
///
/// # Errors
/// For another name.
pub fn form(text: &str) -> Result<Form, String> {
    match text {
        "streaming" => Ok(Form::Streaming),
        "window" => Ok(Form::Window),
        _ => Err("streaming or window".to_owned()),
    }
}

/// A kind of layer by its name.
///
/// # Errors
/// For another name.
pub fn block(text: &str) -> Result<Block, String> {
    match text {
        "released" => Ok(Block::GatedPreNorm),
        "printed" => Ok(Block::ScaledPostNorm),
        _ => Err("released or printed".to_owned()),
    }
}

/// Carries out the verb.
///
/// # Errors
/// `BadInput` for whatever is wrong with options or recordings; an interruption.
pub fn run(options: &Options, caller: &Caller) -> anyhow::Result<Value> {
    let files = files(&options.recordings, &options.leave_out)?;
    let outputs = arm::reads(&options.model).and(&files).file("--out", &options.out);
    let _claim = outputs.check(caller)?;
    let model = arm::model(&options.model)?;
    caller.listen()?;
    let named = read(&files)?;
    let features = features_of(&named)?;
    let simulated = SimulationOptions { period: options.period_s, ..SimulationOptions::PUBLISHED };
    let published = Simulation::new(&model, &features, &simulated)?;
    let wanted = (&features, options.period_s, &options.free[..]);
    let [training, validation] =
        [Role::Training, Role::Validation].map(|role| trajectories(&named, role, wanted));
    let (training, validation) = (training?, validation?);
    let rows = training.iter().flat_map(|one| one.inputs.chunks_exact(features.len()));
    let scale = InputScale::of(&features, rows)?;
    let trained = trained(options);
    trained.check()?;
    let shape = shape(options, &features);
    let mut network = Transformer::<f32>::new(&shape, options.seed)?;
    say_data(&training, &validation, shape.n_parameters(), caller);
    let mut rivals = Rivals::fit(&model, &published, &training, caller)?;
    let observed = observed(options, &model, &features, &training)?;
    rivals.observers = observed.as_ref().map(|(_, observers)| observers.clone());
    let (mut simulated, mut simulation) = (simulated, published);
    if options.prior == Prior::Servo {
        simulated = SimulationOptions::with_servo(&rivals.servo, options.period_s);
        simulation = Simulation::new(&model, &features, &simulated)?;
        network = network.with_silent_head(Heads::TORQUE);
    }
    let currents = CurrentModel::fit(&features, &training)?;
    let mut task = NeuralTask::new(&trained, (&simulation, &scale, &currents), [&training, &validation])?;
    let state = options.out.with_extension("training");
    let second = options.out.with_extension("sensing-training");
    let mut states = vec![state.clone()];
    states.extend(observed.iter().map(|_| second.clone()));
    let unfinished = Unfinished::new(&options.out, states);
    let total = trained.warm_start + trained.updates;
    let bar = caller.progress("updates", total as usize, 0);
    let start = Instant::now();
    let mut listener = |p: &Progress| {
        match p {
            Progress::Step { epoch, done, .. } => {
                bar.set_position(*epoch as u64 * trained.epoch + *done as u64)
            }
            Progress::Epoch(epoch) => bar.set_message(format!(
                "joints {:.3}° in validation, best {:.3}°",
                epoch.validation, epoch.best
            )),
        }
        !caller.is_cancelled()
    };
    let identity = json!({ "shape": shape, "options": trained, "simulation": simulated, "features": features, "recordings": names(&named) });
    let mut session = Session { file: Some(&state), progress: &mut listener };
    let found = fit(&mut task, network, &identity, &mut session)?;
    bar.finish();
    let (mut sensing, mut is_finished) = (None, found.is_finished);
    if let Some((arm, observers)) = observed.as_ref().filter(|_| found.is_finished) {
        let sets = [&training[..], &validation];
        let part = sensed(options, (arm, &features, observers), (sets, &names(&named)), &second, caller)?;
        is_finished = part.1;
        sensing = Some(part.0);
    }
    let rate = task.steps as f64 / start.elapsed().as_secs_f64();
    let mut details = json!({
        "options": trained, "validation_deg": found.validation, "epochs": found.epochs, "recordings": names(&named), "curve": found.curve,
        "left_out": options.leave_out, "rivals": rivals,
    });
    caller.sign(&mut details);
    let names = model.joints().iter().take(features.joints).map(|joint| joint.name.clone()).collect();
    let actuator = NeuralActuator {
        network: found.model,
        features,
        scale,
        simulation: simulated,
        joints: names,
        currents,
        sensing,
        contact: options.contact_n,
        details,
    };
    actuator.write(&options.out)?;
    caller.say(format_args!("{rate:.0} simulated steps a second in training"));
    caller.say(format_args!(
        "joints {:.3}° (root mean square) in rollouts on what was not trained on",
        found.validation
    ));
    unfinished.end(is_finished, caller)?;
    Ok(json!({
        "validation_deg": found.validation, "epochs": found.epochs, "parameters": shape.n_parameters(), "steps_per_second": rate,
        "actuator": options.out,
    }))
}

/// Errors of a servo are some thousandths of a radian: by their squares up to the published radian they would weigh nothing [rad].
const BEND: f64 = 0.005;

fn trained(options: &Options) -> NeuralOptions {
    let published = NeuralOptions::published(u64::from(options.warm_start), u64::from(options.updates));
    let part = u64::from(options.updates).div_ceil(options.horizons.len() as u64);
    let horizons =
        options.horizons.iter().enumerate().map(|(k, horizon)| (k as u64 * part, *horizon)).collect();
    let total = published.warm_start + published.updates;
    // What another network learns does not count in the loop.
    let of_labels = if options.sensing == SensingForm::Loop { 1.0 } else { 0.0 };
    NeuralOptions {
        horizons,
        rollouts: options.rollouts,
        start_noise: options.start_noise,
        pure: options.pure,
        // A tenth of a short training warms up.
        learning_rate: (options.learning_rate, (total / 10).clamp(1, 1000)),
        ema: options.ema,
        loss: LossWeights {
            force: of_labels * LossWeights::PUBLISHED.force,
            gate: of_labels * LossWeights::PUBLISHED.gate,
            condition: of_labels * LossWeights::PUBLISHED.condition,
            contact: options.contact_n,
            position_bend: match options.prior {
                Prior::None => LossWeights::PUBLISHED.position_bend,
                Prior::Servo => BEND,
            },
            ..LossWeights::PUBLISHED
        },
        seed: options.seed,
        ..published
    }
}

/// The arm of the observers, and what they know of it; none where the network in the loop says what acts.
fn observed(
    options: &Options,
    model: &Model,
    features: &Features,
    training: &[Trajectory],
) -> anyhow::Result<Option<(Model, Observers)>> {
    if options.sensing == SensingForm::Loop {
        return Ok(None);
    }
    let arm = observed_arm(model, features.joints)?;
    let observers = identified_observers(&arm, (features, options.period_s), training)?;
    Ok(Some((arm, observers)))
}

/// Trains the network of force, contact and condition; false where it was interrupted.
fn sensed(
    options: &Options,
    (arm, features, observers): (&Model, &Features, &Observers),
    (sets, recordings): ([&[Trajectory]; 2], &[String]),
    state: &Path,
    caller: &Caller,
) -> anyhow::Result<(Sensing, bool)> {
    let trained = SensingOptions::small(options.sensing_updates as u64, options.contact_n, options.seed);
    let about = (features, &observers.drive, options.period_s);
    let mut task = SensingTask::new(&trained, arm, about, sets)?;
    let network = Transformer::<f32>::new(&trained.shape(features), options.seed)?;
    let bar = caller.progress("updates of force and condition", options.sensing_updates, 0);
    let mut listener = |p: &Progress| {
        match p {
            Progress::Step { epoch, done, .. } => {
                bar.set_position(*epoch as u64 * trained.epoch + *done as u64)
            }
            Progress::Epoch(epoch) => {
                bar.set_message(format!("loss {:.4} in validation, best {:.4}", epoch.validation, epoch.best))
            }
        }
        !caller.is_cancelled()
    };
    let identity =
        json!({ "options": trained, "features": features, "observers": observers, "recordings": recordings });
    let mut session = Session { file: Some(state), progress: &mut listener };
    let found = fit(&mut task, network, &identity, &mut session)?;
    bar.finish();
    caller.say(format_args!("force, contact and condition: loss {:.4} in validation", found.validation));
    let sensing =
        Sensing { network: found.model, scale: task.scale().clone(), drive: observers.drive.clone() };
    Ok((sensing, found.is_finished))
}

fn shape(options: &Options, features: &Features) -> TransformerShape {
    let published = TransformerShape::published(features.len(), &Heads::sizes(features), options.form);
    let width = options.width.next_multiple_of(published.attention_heads);
    TransformerShape {
        width,
        layers: options.layers,
        feed_forward: 2 * width,
        latent: (width / 2).max(1),
        block: options.block,
        ..published
    }
}

/// What all recordings have: motors, and a gripper as the last of them where they know its aperture.
pub(super) fn features_of(named: &[Named]) -> anyhow::Result<Features> {
    let motors = |one: &Named| -> anyhow::Result<usize> {
        let within = |bad: BadInput| bad.within(one.path.display());
        Ok(Recorded::of(&one.recording).map_err(within)?.joints.len())
    };
    let all: Vec<&Recording> = named.iter().map(|one| &one.recording).collect();
    let m = motors(&named[0])?;
    let owned: Vec<Recording> = all.into_iter().cloned().collect();
    let gripper = gripper_of(&owned)?;
    if gripper.is_some() && m < 2 {
        return Err(
            BadInput::new("recordings", "joints beside the gripper's motor", "that motor alone").into()
        );
    }
    Ok(Features { joints: m - usize::from(gripper.is_some()), gripper })
}

/// The trajectories of a role, for these inputs at this period [s]; paths that contain one of `free` move freely.
pub(super) fn trajectories(
    named: &[Named],
    role: Role,
    (features, period, free): (&Features, f64, &[String]),
) -> anyhow::Result<Vec<Trajectory>> {
    let one = |one: &Named| -> anyhow::Result<Trajectory> {
        let path = one.path.display().to_string();
        let is_free = free.iter().any(|part| path.contains(part.as_str()));
        let unlabelled = if is_free { Unlabelled::Free } else { Unlabelled::Unknown };
        let found =
            trajectory_of(&one.recording, features, period, unlabelled).map_err(|bad| bad.within(&path))?;
        Ok(Trajectory { name: path, ..found })
    };
    let found: Vec<Trajectory> =
        named.iter().filter(|one| one.role == role).map(one).collect::<anyhow::Result<_>>()?;
    if found.is_empty() && role != Role::Test {
        let expected = "two or more, one of them for validation";
        let found = if role == Role::Training { "none for training" } else { "none for validation" };
        return Err(BadInput::new("recordings", expected, found).into());
    }
    Ok(found)
}

fn names(named: &[Named]) -> Vec<String> {
    named.iter().map(|one| format!("{} ({} rows)", one.path.display(), one.recording.n_samples())).collect()
}

/// What is known of labels before anything is trained.
fn say_data(training: &[Trajectory], validation: &[Trajectory], n_parameters: usize, caller: &Caller) {
    let rows: usize = training.iter().map(Trajectory::len).sum();
    let labelled = training.iter().flat_map(|one| &one.force).filter(|force| force.is_some()).count();
    let conditions = training.iter().filter(|one| one.is_healthy == Some(false)).count();
    caller.say(format_args!(
        "{} trajectories with {rows} rows to learn from, {} to validate; {n_parameters} parameters",
        training.len(),
        validation.len()
    ));
    if labelled == 0 {
        caller.say("no row says what force acts: force and contact are not learned");
    }
    if conditions == 0 {
        caller.say("no recording has a degraded motor: the condition is not learned");
    }
}

/// What the network has to beat, fitted to the same trajectories.
#[derive(serde::Serialize, serde::Deserialize)]
pub(super) struct Rivals {
    #[serde(rename = "lag_and_droop")]
    pub lag: LagAndDroop,
    pub servo: ServoModel,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub observers: Option<Observers>,
}

impl Rivals {
    fn fit(
        model: &Model,
        simulation: &Simulation,
        training: &[Trajectory],
        caller: &Caller,
    ) -> anyhow::Result<Self> {
        let features = simulation.features();
        let lag = LagAndDroop::fit(simulation.model(), features, training)?;
        let watch = |_: usize, _: f64| !caller.is_cancelled();
        let servo = ServoModel::fit(model, (features, simulation.options().period), training, &watch)?;
        Ok(Self { lag, servo, observers: None })
    }
}
