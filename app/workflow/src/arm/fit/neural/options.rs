//! Options of `arm fit neural`, and what they mean for a training.

use std::path::PathBuf;

use hysteron_actuator::CatalogueDrive;
use hysteron_arm_learning::neural::{
    ActuatorOptions, LossWeights, MotorModelKind, Motors, NeuralOptions, SensingOptions,
};
use hysteron_base::BadInput;
use hysteron_learn::{BlockKind, TemporalForm};

use crate::arm::RobotOptions;

/// Learn the torques of an arm's motors from their telemetry, without measured torques
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
    /// How the robot is read
    #[cfg_attr(feature = "clap", command(flatten))]
    pub robot_options: RobotOptions,
    /// Do not learn from recordings whose path contains this, as in `weight/pick_place_object_500g`; may be repeated
    #[cfg_attr(feature = "clap", arg(long, value_name = "TEXT"))]
    pub leave_out: Vec<String>,
    /// Recordings whose path contains this move freely: a sample without label of force is one of no force; may be repeated
    #[cfg_attr(feature = "clap", arg(long, value_name = "TEXT", default_value = "force_unlabeled"))]
    pub free: Vec<String>,
    /// streaming (one token a step), or window (all tokens every step, as published)
    #[cfg_attr(feature = "clap", arg(long, value_name = "FORM", default_value = "streaming", value_parser = form))]
    pub form: TemporalForm,
    /// released (normalisation first, gated attention, GELU), printed (equations 4 and 5 of the paper), or gru or lstm in their place (with
    /// as many parameters)
    #[cfg_attr(feature = "clap", arg(long, value_name = "LAYERS", default_value = "released", value_parser = block))]
    pub block: BlockKind,
    /// Numbers of a token within the network; the feed-forward networks have twice as many, the heads half
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value_t = 192, value_parser = crate::shared::number::count::<1024>))]
    pub width: usize,
    /// Layers of the network
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value_t = 4, value_parser = crate::shared::number::count::<16>))]
    pub layers: usize,
    /// Model that moves the simulated motors next to the network: none (as published), servo (stiffness, friction and damping
    /// identified by rollout, to whose torque the network's is added), or drive (that of --drive, likewise)
    #[cfg_attr(feature = "clap", arg(long, value_name = "PRIOR", default_value = "none", value_parser = prior))]
    pub prior: MotorModelKind,
    /// Drive of every motor for --prior drive, with its thermal model and its limits of voltage and current: a name, or a file of arm identify
    /// servo --drive-out; recordings need their position_gain
    #[cfg_attr(feature = "clap", arg(long, value_name = "DRIVE"))]
    pub drive: Option<String>,
    /// Updates on torques by inverse dynamics, before the closed loop
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value_t = 2000, value_parser = crate::shared::number::up_to::<1_000_000>))]
    pub warm_start: u32,
    /// Updates in the closed loop
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value_t = 10_000, value_parser = crate::shared::number::up_to::<1_000_000>))]
    pub updates: u32,
    /// Steps of a rollout: these, one after the other, each for an equal part of the updates
    #[cfg_attr(feature = "clap", arg(long, value_name = "N,...", value_delimiter = ',', default_values_t = [64, 128, 256, 320, 500], value_parser = crate::shared::number::count::<100_000>))]
    pub horizons: Vec<usize>,
    /// Rollouts of an update
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value_t = 16, value_parser = crate::shared::number::count::<4096>))]
    pub rollouts: usize,
    /// Where force, contact and condition come from: loop (the network in the loop, as published), or observer (a second network,
    /// whose inputs are recorded telemetry with PWM and whose output is added to the force of a momentum observer)
    #[cfg_attr(feature = "clap", arg(long, value_name = "FROM", default_value = "loop", value_parser = sensing))]
    pub sensing: SensingForm,
    /// Updates of that second network
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value_t = 12_000, value_parser = crate::shared::number::count::<1_000_000>))]
    pub sensing_updates: usize,
    /// Part of the rollouts, and of the error in validation, in pure simulation: currents by the model of the drives
    #[cfg_attr(feature = "clap", arg(long, value_name = "PART", default_value_t = 0.0, value_parser = crate::shared::number::part))]
    pub pure: f64,
    /// Full step size
    #[cfg_attr(feature = "clap", arg(long, value_name = "RATE", default_value_t = 1e-4, value_parser = crate::shared::number::learning_rate))]
    pub learning_rate: f64,
    /// Part of the moving average of the weights that each update replaces
    #[cfg_attr(feature = "clap", arg(long, value_name = "PART", default_value_t = 1e-3))]
    pub ema: f32,
    /// Initial positions of a rollout are off by up to this [rad]
    #[cfg_attr(feature = "clap", arg(long, value_name = "RAD", default_value_t = 0.15, value_parser = crate::shared::number::angle_rad))]
    pub start_noise: f64,
    /// A force longer than this is a contact [N]; above the noise of the sensor that labels it
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value_t = 0.01))]
    pub contact_n: f64,
    /// Step of the simulation [s]
    #[cfg_attr(feature = "clap", arg(long, value_name = "S", default_value_t = 0.017, value_parser = crate::shared::number::period_s))]
    pub period_s: f64,
    /// Rotor and gears of every joint's motor, at the output [default: 0.1 as published; 0.02 with --prior servo; the drive's]
    #[cfg_attr(feature = "clap", arg(long, value_name = "KG_M2", allow_negative_numbers = true))]
    pub armature_kg_m2: Option<f64>,
    /// Damping of every joint's motor [default: 1 as published; with --prior servo it is identified; the drive's]
    #[cfg_attr(feature = "clap", arg(long, value_name = "D", allow_negative_numbers = true))]
    pub damping_n_m_s_per_rad: Option<f64>,
    /// Largest torque of a joint's motor [default: 5 as published; what the drive stalls at]
    #[cfg_attr(feature = "clap", arg(long, value_name = "N_M", allow_negative_numbers = true))]
    pub torque_limit_n_m: Option<f64>,
    /// Friction of the servo of --prior servo grows with the torque through the gear, by a share that is identified with it
    #[cfg_attr(feature = "clap", arg(long))]
    pub load_friction: bool,
    /// Of initial weights, batches and noise
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value_t = 0))]
    pub seed: u64,
}

/// A prior by its name.
///
/// # Errors
/// For another name.
pub fn prior(text: &str) -> Result<MotorModelKind, String> {
    match text {
        "none" => Ok(MotorModelKind::None),
        "servo" => Ok(MotorModelKind::Servo),
        "drive" => Ok(MotorModelKind::Drive),
        _ => Err("none, servo or drive".to_owned()),
    }
}

/// Where force, contact and condition come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SensingForm {
    /// The network in the loop, as published.
    Loop,
    /// A network of their own, together with a momentum observer.
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
pub fn form(text: &str) -> Result<TemporalForm, String> {
    match text {
        "streaming" => Ok(TemporalForm::Streaming),
        "window" => Ok(TemporalForm::Window),
        _ => Err("streaming or window".to_owned()),
    }
}

/// A kind of layer by its name.
///
/// # Errors
/// For another name.
pub fn block(text: &str) -> Result<BlockKind, String> {
    match text {
        "released" => Ok(BlockKind::GatedPreNorm),
        "printed" => Ok(BlockKind::ScaledPostNorm),
        "gru" => Ok(BlockKind::Gru),
        "lstm" => Ok(BlockKind::Lstm),
        _ => Err("released, printed, gru or lstm".to_owned()),
    }
}

impl Options {
    /// Options of the actuator, with the drive that `--drive` names.
    ///
    /// # Errors
    /// `BadInput` for a drive without the prior that it is for, or that prior without a drive.
    pub(super) fn actuator(&self, drive: Option<CatalogueDrive>) -> Result<ActuatorOptions, BadInput> {
        if drive.is_some() != (self.prior == MotorModelKind::Drive) {
            let (expected, found) = match drive {
                Some(_) => ("--prior drive with it", "another prior"),
                None => ("a name or a file, for --prior drive", "none"),
            };
            return Err(BadInput::new("--drive", expected, found));
        }
        let sensing = || SensingOptions::small(self.sensing_updates as u64, self.contact_n, self.seed);
        Ok(ActuatorOptions {
            form: self.form,
            block: self.block,
            width: self.width,
            layers: self.layers,
            tokens: ActuatorOptions::TOKENS,
            prior: self.prior,
            training: self.training(),
            sensing: (self.sensing == SensingForm::Observer).then(sensing),
            period: self.period_s,
            motors: Motors {
                armature: self.armature_kg_m2,
                damping: self.damping_n_m_s_per_rad,
                torque_limit: self.torque_limit_n_m,
                load_friction: self.load_friction,
            },
            drive,
        })
    }

    /// How the network in the loop is trained.
    fn training(&self) -> NeuralOptions {
        let published = NeuralOptions::published(u64::from(self.warm_start), u64::from(self.updates));
        let part = u64::from(self.updates).div_ceil(self.horizons.len() as u64);
        let horizons =
            self.horizons.iter().enumerate().map(|(k, horizon)| (k as u64 * part, *horizon)).collect();
        let total = published.warm_start + published.updates;
        // What another network learns does not count in the loop.
        let of_labels = if self.sensing == SensingForm::Loop { 1.0 } else { 0.0 };
        NeuralOptions {
            horizons,
            rollouts: self.rollouts,
            start_noise: self.start_noise,
            pure: self.pure,
            // A tenth of a short training warms up.
            learning_rate: (self.learning_rate, (total / 10).clamp(1, 1000)),
            ema: self.ema,
            loss: LossWeights {
                force: of_labels * LossWeights::PUBLISHED.force,
                gate: of_labels * LossWeights::PUBLISHED.gate,
                condition: of_labels * LossWeights::PUBLISHED.condition,
                contact: self.contact_n,
                position_bend: match self.prior {
                    MotorModelKind::None => LossWeights::PUBLISHED.position_bend,
                    MotorModelKind::Servo | MotorModelKind::Drive => LossWeights::SERVO_BEND,
                },
                ..LossWeights::PUBLISHED
            },
            seed: self.seed,
            ..published
        }
    }
}
