//! `hysteron arm fit neural`: an actuator from telemetry alone.

use std::path::PathBuf;
use std::time::Instant;

use hysteron_arm::Recorded;
use hysteron_arm::neural::{
    ActuatorOptions, ActuatorSession, Features, LossWeights, Motors, NeuralActuator, NeuralOptions, Prior,
    SensingOptions, Stage, Trajectory, Unlabelled, fit_actuator, gripper_of, trajectory_of,
};
use hysteron_base::checks::Purpose;
use hysteron_base::{BadInput, Recording, json};
use hysteron_learn::{Block, Form, Progress};
use hysteron_report::verdict::{Criterion, Verdict};
use serde_json::Value;

use super::recordings::{Named, Role, checked, files, read};
use crate::arm::identify::deviation;
use crate::shared::resume::Unfinished;
use crate::{Context, arm, shared::verdict};

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
    /// How the robot is read
    #[cfg_attr(feature = "clap", command(flatten))]
    pub robot_options: arm::RobotOptions,
    /// Do not learn from recordings whose path contains this, as in `weight/pick_place_object_500g`; may be repeated
    #[cfg_attr(feature = "clap", arg(long, value_name = "TEXT"))]
    pub leave_out: Vec<String>,
    /// Recordings whose path contains this move freely: a sample without label of force is one of no force; may be repeated
    #[cfg_attr(feature = "clap", arg(long, value_name = "TEXT", default_value = "force_unlabeled"))]
    pub free: Vec<String>,
    /// streaming (one token a step), or window (all tokens every step, as published)
    #[cfg_attr(feature = "clap", arg(long, value_name = "FORM", default_value = "streaming", value_parser = form))]
    pub form: Form,
    /// released (normalisation first, gated attention, GELU), printed (equations 4 and 5 of the paper), or gru or lstm in their place (with
    /// as many parameters)
    #[cfg_attr(feature = "clap", arg(long, value_name = "LAYERS", default_value = "released", value_parser = block))]
    pub block: Block,
    /// Numbers of a token within the network; the feed-forward networks have twice as many, the heads half
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value_t = 192, value_parser = crate::shared::number::count::<1024>))]
    pub width: usize,
    /// Layers of the network
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value_t = 4, value_parser = crate::shared::number::count::<16>))]
    pub layers: usize,
    /// What moves the simulated motors beside the network: none (as published), servo (stiffness, friction and damping
    /// identified by rollout, to whose torque the network's is added), or drive (that of --drive, likewise)
    #[cfg_attr(feature = "clap", arg(long, value_name = "PRIOR", default_value = "none", value_parser = prior))]
    pub prior: Prior,
    /// Drive of every motor for --prior drive, with its heat and its limits of voltage and current: a name, or a file of arm identify
    /// servo --drive-out; recordings must say their position_gain
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
    /// Where force, contact and condition come from: loop (the network in the loop, as published), or observer (a second network that
    /// sees recorded telemetry with PWM, and the force of a momentum observer that it adds to)
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
pub fn prior(text: &str) -> Result<Prior, String> {
    match text {
        "none" => Ok(Prior::None),
        "servo" => Ok(Prior::Servo),
        "drive" => Ok(Prior::Drive),
        _ => Err("none, servo or drive".to_owned()),
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
        "gru" => Ok(Block::Gru),
        "lstm" => Ok(Block::Lstm),
        _ => Err("released, printed, gru or lstm".to_owned()),
    }
}

/// Carries out the verb.
///
/// # Errors
/// `BadInput` for whatever is wrong with options or recordings; an interruption.
pub fn run(options: &Options, context: &Context) -> anyhow::Result<Value> {
    let files = files(&options.recordings, &options.leave_out)?;
    let drive_file = options.drive.as_deref().and_then(arm::file_of);
    let outputs = arm::reads(&options.model).and(&files).and(drive_file).learned("--out", &options.out);
    let _claim = outputs.check(context)?;
    let model = options.robot_options.model(&options.model, context)?;
    let drive = options.drive.as_deref().map(arm::drive).transpose()?;
    if drive.is_some() != (options.prior == Prior::Drive) {
        let (expected, found) = match drive {
            Some(_) => ("--prior drive beside it", "another prior"),
            None => ("a name or a file, for --prior drive", "none"),
        };
        return Err(BadInput::new("--drive", expected, found).into());
    }
    context.listen();
    let named = read(&files)?;
    let findings = checked(&named, &model, Purpose::Fit)?;
    let features = features_of(&named)?;
    let wanted = (&features, options.period_s, &options.free[..]);
    let [training, validation] =
        [Role::Training, Role::Validation].map(|role| trajectories(&named, role, wanted));
    let (training, validation) = (training?, validation?);
    let asked = ActuatorOptions {
        form: options.form,
        block: options.block,
        width: options.width,
        layers: options.layers,
        tokens: ActuatorOptions::TOKENS,
        prior: options.prior,
        training: trained(options),
        sensing: (options.sensing == SensingForm::Observer)
            .then(|| SensingOptions::small(options.sensing_updates as u64, options.contact_n, options.seed)),
        period: options.period_s,
        motors: Motors {
            armature: options.armature_kg_m2,
            damping: options.damping_n_m_s_per_rad,
            torque_limit: options.torque_limit_n_m,
            load_friction: options.load_friction,
        },
        drive,
    };
    let n_parameters = asked.shape(&features).n_parameters();
    say_data(&training, &validation, n_parameters, context);
    let files = ["training", "sensing-training"].map(|ending| options.out.with_extension(ending));
    let unfinished =
        Unfinished::new(&options.out, files[..1 + usize::from(asked.sensing.is_some())].to_vec());
    let start = Instant::now();
    let mut bars = Bars { context, options: &asked, bars: [None, None] };
    let mut session = ActuatorSession {
        recordings: &names(&named),
        files: [&files[0], &files[1]],
        progress: &mut |stage, p| bars.show(stage, p),
    };
    let found = fit_actuator(&model, &features, [&training, &validation], &asked, &mut session)?;
    bars.finish();
    // Without the second network it would pass for another actuator.
    if found.actuator.sensing.is_some() != asked.sensing.is_some() {
        return Err(unfinished.nothing_written());
    }
    let rate = found.steps as f64 / start.elapsed().as_secs_f64();
    let mut details = json!({
        "options": asked.training, "sensing_options": asked.sensing, "validation_deg": found.validation, "epochs": found.epochs,
        "recordings": names(&named), "curve": found.curve, "left_out": options.leave_out,
        "rivals": found.actuator.details["rivals"],
    });
    context.sign(&mut details);
    let actuator = NeuralActuator { details, ..found.actuator };
    actuator.write(&options.out)?;
    context.print(format_args!("{rate:.0} simulated steps a second in training"));
    context.print(format_args!(
        "joints {:.3}° (root mean square) in rollouts on what was not trained on",
        found.validation
    ));
    if let Some(loss) = found.sensing_validation {
        context
            .print(format_args!("force, contact and condition: loss {loss:.4} on what was not trained on"));
    }
    unfinished.end(found.is_finished, context)?;
    Ok(json!({
        "validation_deg": found.validation, "epochs": found.epochs, "parameters": n_parameters, "steps_per_second": rate,
        "sensing_validation": found.sensing_validation, "actuator": options.out,
        "verdict": judged(found.validation, &validation, &features), "recording_warnings": findings,
    }))
}

/// Whether the actuator moves the arm as measured: error of the joints in rollouts on what was not trained on [deg].
fn judged(error: f64, validation: &[Trajectory], features: &Features) -> Verdict {
    let (n, width) = (features.joints, 2 * (features.joints + usize::from(features.gripper.is_some())));
    let squares = |j: usize| {
        let rows = validation.iter().flat_map(|one| one.states.chunks_exact(width));
        let positions: Vec<f64> = rows.map(|row| row[j]).collect();
        deviation(&positions).to_degrees().powi(2)
    };
    let spread = ((0..n).map(squares).sum::<f64>() / n as f64).sqrt();
    let judged = Verdict::on(format!("joints are simulated within {error:.2}° (RMS)")).because(
        Criterion::ErrorOverSpread,
        error / spread,
        format!("on what was not trained on, joints are off by {error:.2}°; they move by {spread:.2}° about their mean"),
    );
    verdict::repeated(judged, validation.len(), "trajectory in validation").verdict()
}

/// A bar for either network.
struct Bars<'a> {
    context: &'a Context<'a>,
    options: &'a ActuatorOptions,
    bars: [Option<Box<dyn crate::Progress>>; 2],
}

impl Bars<'_> {
    fn show(&mut self, stage: Stage, p: &Progress) -> bool {
        let Self { context, options, bars } = self;
        let trained = &options.training;
        let (k, title, of, epoch) = match (stage, &options.sensing) {
            (Stage::Sensing, Some(own)) => (1, "updates of force and condition", own.updates, own.epoch),
            _ => (0, "updates", trained.warm_start + trained.updates, trained.epoch),
        };
        let bar = bars[k].get_or_insert_with(|| context.progress(title, of as usize, 0));
        match p {
            Progress::Step { epoch: done_epochs, done, .. } => {
                bar.set_position(*done_epochs as u64 * epoch + *done as u64)
            }
            Progress::Epoch(own) if stage == Stage::Loop => {
                bar.set_message(format!("joints {:.3}° in validation, best {:.3}°", own.validation, own.best))
            }
            Progress::Epoch(own) => {
                bar.set_message(format!("loss {:.4} in validation, best {:.4}", own.validation, own.best))
            }
        }
        !context.is_cancelled()
    }

    fn finish(&self) {
        self.bars.iter().flatten().for_each(|bar| bar.finish());
    }
}

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
                Prior::Servo | Prior::Drive => LossWeights::SERVO_BEND,
            },
            ..LossWeights::PUBLISHED
        },
        seed: options.seed,
        ..published
    }
}

/// Features common to all recordings: motors, and a gripper as the last of them where its aperture is known.
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

/// Prints a summary of the labels before training.
fn say_data(training: &[Trajectory], validation: &[Trajectory], n_parameters: usize, context: &Context) {
    let rows: usize = training.iter().map(Trajectory::len).sum();
    let labelled = training.iter().flat_map(|one| &one.force).filter(|force| force.is_some()).count();
    let conditions = training.iter().filter(|one| one.is_healthy == Some(false)).count();
    context.print(format_args!(
        "{} trajectories with {rows} rows to learn from, {} to validate; {n_parameters} parameters",
        training.len(),
        validation.len()
    ));
    if labelled == 0 {
        context.print("no row says what force acts: force and contact are not learned");
    }
    if conditions == 0 {
        context.print("no recording has a degraded motor: the condition is not learned");
    }
}
