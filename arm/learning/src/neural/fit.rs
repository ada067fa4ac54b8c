//! `fit_actuator`: an actuator from trajectories: what it has to beat, the network in the loop, and that of force and condition.

use std::path::Path;

use hysteron_actuator::CatalogueDrive;
use hysteron_base::{BadInput, json};
use hysteron_learn::{
    BlockKind, DeviceCard, Error, FitResult, Result, TemporalForm, TrainingProgress, TrainingSession,
    Transformer, TransformerShape, fit,
};
use serde::{Deserialize, Serialize};

use super::actuator::NeuralActuator;
use super::baselines::FirstOrderServo;
use super::current::CurrentModel;
use super::data::Trajectory;
use super::details::{ActuatorDetails, Baselines};
use super::features::{FeatureLayout, InputScale};
use super::loss::Heads;
use super::motors::Motors;
use super::observations::IdentifiedArm;
use super::sensing::Sensing;
use super::sensing_training::{SensingOptions, SensingTask, identified_observers};
use super::servo::RolloutServo;
use super::simulation::{ArmSimulation, SimulationOptions};
use super::training::{NeuralOptions, NeuralTask};
use hysteron_arm_dynamics::Model;
use hysteron_arm_estimation::servo_force::{BaselineObservers, observed_arm};

/// Model that drives the simulated motors next to the network.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MotorModelKind {
    /// Nothing, as published.
    None,
    /// A position servo identified by rollout.
    Servo,
    /// A drive that was identified before, in every motor.
    Drive,
}

/// An actuator that is asked for.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ActuatorOptions {
    /// How the network in the loop meets time.
    pub form: TemporalForm,
    /// How its layers are put together.
    pub block: BlockKind,
    /// Numbers of a token within it; the feed-forward networks have twice as many, the heads half. Recurrent layers have the width with
    /// which the network is nearest in its number of parameters.
    pub width: usize,
    /// Its layers.
    pub layers: usize,
    /// Samples that it sees, the current one among them.
    pub tokens: usize,
    /// Model that drives the simulated motors next to it.
    pub prior: MotorModelKind,
    /// How it is trained.
    pub training: NeuralOptions,
    /// Force, contact and condition by a network of their own; none where the network in the loop estimates them, as published.
    pub sensing: Option<SensingOptions>,
    /// Step of the simulation [s].
    pub period: f64,
    /// Parameters of the simulated motors.
    #[serde(default, skip_serializing_if = "Motors::are_published")]
    pub motors: Motors,
    /// The drive of [`MotorModelKind::Drive`].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub drive: Option<CatalogueDrive>,
}

impl ActuatorOptions {
    /// Tokens of NeuralActuator's release.
    pub const TOKENS: usize = 9;

    /// The network in the loop for these motors.
    pub fn shape(&self, features: &FeatureLayout) -> TransformerShape {
        let published = TransformerShape::published(features.len(), &Heads::sizes(features), self.form);
        let of = |block: BlockKind, width: usize| TransformerShape {
            width,
            layers: self.layers,
            feed_forward: 2 * width,
            latent: (self.width.next_multiple_of(published.attention_heads) / 2).max(1),
            tokens: self.tokens,
            block,
            ..published.clone()
        };
        let step = published.attention_heads;
        let width = self.width.next_multiple_of(step);
        if !matches!(self.block, BlockKind::Gru | BlockKind::Lstm) {
            return of(self.block, width);
        }
        let published = of(BlockKind::GatedPreNorm, width).n_parameters();
        let all = (1..=2 * width.div_ceil(step)).map(|k| of(self.block, k * step));
        all.min_by_key(|shape| shape.n_parameters().abs_diff(published))
            .unwrap_or_else(|| of(self.block, width))
    }
}

impl Baselines {
    /// As they were fitted with an actuator.
    ///
    /// # Errors
    /// `BadInput` where its file has none, or such as are for other motors.
    pub fn of(actuator: &NeuralActuator) -> std::result::Result<Self, BadInput> {
        let missing = || BadInput::new("rivals", "those of arm fit neural", "none");
        let baselines = actuator.details.baselines.clone().ok_or_else(missing)?;
        let features = &actuator.features;
        let m = features.motors();
        if [baselines.lag.lag.len(), baselines.lag.droop.len()] != [m; 2] {
            let found = format!("{} and {}", baselines.lag.lag.len(), baselines.lag.droop.len());
            return Err(BadInput::new("rivals: lag_and_droop", format!("{m} of both"), found));
        }
        baselines.servo.check(features).map_err(|bad| bad.within("rivals"))?;
        let observers = baselines.observers.as_ref().map_or(Ok(()), |own| own.check(features.joints));
        observers.map_err(|bad| bad.within("rivals: observers"))?;
        Ok(baselines)
    }
}

/// Which network is trained.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TrainingStage {
    /// That in the loop.
    Loop,
    /// That of force, contact and condition.
    Sensing,
}

/// Files of a training between runs, and the receiver of its reports.
pub struct ActuatorSession<'a> {
    /// Names of the training's recordings, which identify it.
    pub recordings: &'a [String],
    /// Files to resume from, of both networks.
    pub files: [&'a Path; 2],
    /// Gets the progress; ends the training where it returns false.
    pub progress: &'a mut dyn FnMut(TrainingStage, &TrainingProgress) -> bool,
}

/// Result of a training: actuator, validation errors and learning curve.
#[derive(Debug, Clone)]
pub struct ActuatorFit {
    /// With the best weights; its details are the baselines.
    pub actuator: NeuralActuator,
    /// Root mean square error of the joints in rollouts of the validation trajectories [deg].
    pub validation: f64,
    /// Loss of force, contact and condition there, where a network of their own was trained.
    pub sensing_validation: Option<f64>,
    /// Epochs done when the weights in the loop were found.
    pub epochs: usize,
    /// Of every epoch in the loop, the error in training and in validation.
    pub curve: Vec<[f64; 2]>,
    /// Steps that were simulated.
    pub steps: u64,
    /// False where it was stopped early and can resume from its files.
    pub is_finished: bool,
}

/// Trains an actuator of `model` on the first set of trajectories, and keeps what does best on the second.
///
/// # Errors
/// `BadInput` for options out of range or trajectories that lack something; files of another training.
pub fn fit_actuator(
    model: &Model,
    features: &FeatureLayout,
    sets: [&[Trajectory]; 2],
    options: &ActuatorOptions,
    session: &mut ActuatorSession<'_>,
) -> Result<ActuatorFit> {
    options.training.check()?;
    options.motors.check()?;
    let [training, _] = sets;
    let alone = SimulationOptions::without_servo(&options.motors, options.period);
    let simulation = ArmSimulation::new(model, features, &alone)?;
    let rows = training.iter().flat_map(|one| one.inputs.chunks_exact(features.len()));
    let scale = InputScale::of(features, rows)?;
    let arm = options.sensing.as_ref().map(|_| observed_arm(model, features.joints)).transpose()?;
    let observe = |arm: &Model| identified_observers(arm, (features, options.period), training);
    let baselines = Baselines {
        lag: FirstOrderServo::fit(simulation.model(), features, training)?,
        servo: RolloutServo::fit(model, (features, options.period, &options.motors), training, &|_, _| true)?,
        observers: arm.as_ref().map(observe).transpose()?,
    };
    let mut network = Transformer::<f32>::new(&options.shape(features), options.training.seed)?;
    let driven = match options.prior {
        MotorModelKind::None => None,
        MotorModelKind::Servo => Some(SimulationOptions::with_servo(&baselines.servo, options.period)),
        MotorModelKind::Drive => {
            let missing = || BadInput::new("drive", "one, for a drive in the loop", "none");
            let drive = options.drive.as_ref().ok_or_else(missing)?;
            Some(SimulationOptions::with_drive(drive, &options.motors, options.period))
        }
    };
    let mut simulation = simulation;
    if let Some(driven) = driven {
        simulation = ArmSimulation::new(model, features, &driven)?;
        network = network.with_silent_head(Heads::TORQUE);
    }
    let currents = CurrentModel::fit(features, training)?;
    let mut task = NeuralTask::new(&options.training, (&simulation, &scale, &currents), sets)?;
    let identity = json!({
        "shape": hysteron_learn::TrainableModel::shape(&network), "options": options.training, "simulation": simulation.options(),
        "features": features, "recordings": session.recordings,
    });
    let mut listener = |p: &TrainingProgress| (session.progress)(TrainingStage::Loop, p);
    let mut own = TrainingSession { file: Some(session.files[0]), progress: &mut listener };
    let found = fit(&mut task, network, &identity, &mut own)?;
    let steps = task.steps;
    let (mut sensing, mut sensing_validation, mut is_finished) = (None, None, found.is_finished);
    if let (true, Some(arm), Some(trained), Some(observers)) =
        (is_finished, &arm, &options.sensing, &baselines.observers)
    {
        let about = (arm, features, options.period);
        match fit_sensing(about, observers, sets, trained, session) {
            Ok((own, found)) => {
                is_finished = found.is_finished;
                sensing_validation = Some(found.validation);
                sensing = Some(own);
            }
            // Ended before its first epoch: the network in the loop is whole.
            Err(Error::NothingTrained) => is_finished = false,
            Err(error) => return Err(error),
        }
    }
    let names = model.joints().iter().take(features.joints).map(|joint| joint.name.clone()).collect();
    let actuator = NeuralActuator {
        network: found.model,
        features: *features,
        scale,
        simulation: simulation.options().clone(),
        joints: names,
        currents,
        sensing,
        contact: options.training.loss.contact,
        details: ActuatorDetails { baselines: Some(baselines), ..ActuatorDetails::default() },
    };
    let (validation, epochs, curve) = (found.validation, found.epochs, found.curve);
    Ok(ActuatorFit { actuator, validation, sensing_validation, epochs, curve, steps, is_finished })
}

/// Trains the network of force, contact and condition on `sets` (training, validation); `arm` is as
/// [`hysteron_arm_estimation::servo_force::observed_arm`] gives it, samples lie `period` apart [s].
///
/// # Errors
/// `BadInput` where nothing can be learned from the sets, a damaged or foreign state of a training, or a card that does not answer.
pub fn fit_sensing(
    (arm, features, period): (&Model, &FeatureLayout, f64),
    observers: &BaselineObservers,
    sets: [&[Trajectory]; 2],
    options: &SensingOptions,
    session: &mut ActuatorSession<'_>,
) -> Result<(Sensing, FitResult<Transformer<f32>>)> {
    let known = IdentifiedArm::identify(arm, (features, &observers.drive, period), sets[0])?;
    let task = SensingTask::new(options, arm, (features, &known, period), sets)?;
    let mut task = task.on(DeviceCard::first()?);
    let network = Transformer::<f32>::new(&options.shape(features), options.seed)?;
    let identity = json!({
        "options": options, "features": features, "observers": observers, "recordings": session.recordings,
    });
    let mut listener = |p: &TrainingProgress| (session.progress)(TrainingStage::Sensing, p);
    let mut own = TrainingSession { file: Some(session.files[1]), progress: &mut listener };
    let found = fit(&mut task, network, &identity, &mut own)?;
    let sensing = Sensing { network: found.model.clone(), scale: task.scale().clone(), known };
    Ok((sensing, found))
}
