//! `hysteron arm estimate`: torques, force on the tip, contact and condition of a motor, sample by sample, along a
//! recording or on a bus; or external torques with learned dynamics.

mod external;
mod live;

use std::path::PathBuf;

use hysteron_arm::neural::{Estimator, NeuralActuator, SensedNow, Unlabelled, trajectory_of};
use hysteron_base::{BadInput, Channel, Recording, json};
use serde_json::Value;

use crate::{Context, arm, arm::learned_dynamics};

/// Estimate torques, force, contact and motor condition from servo telemetry, along a recording or live on a bus; or
/// external torques along a recording with learned dynamics
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    /// Actuator by hysteron arm fit neural --sensing observer, or model by hysteron arm fit delan
    pub actuator: PathBuf,
    /// Recording of the arm
    #[cfg_attr(
        feature = "clap",
        arg(value_name = "REC", required_unless_present = "live", conflicts_with = "live")
    )]
    pub recording: Option<PathBuf>,
    /// Estimate while a follower follows its leader, as `hysteron arm record` does: file of both arms (.toml)
    #[cfg_attr(feature = "clap", arg(long, value_name = "FILE"))]
    pub live: Option<PathBuf>,
    /// Live: end after that many seconds [default: at Ctrl-C]
    #[cfg_attr(
        feature = "clap",
        arg(long, value_name = "SECONDS", allow_negative_numbers = true, requires = "live")
    )]
    pub seconds: Option<f64>,
    /// Recording to write, .csv or .parquet
    #[cfg_attr(feature = "clap", arg(long, value_name = "FILE"))]
    pub out: PathBuf,
    /// The arm: a file of URDF or MJCF, or a built-in name
    #[cfg_attr(feature = "clap", arg(long, value_name = "MODEL", default_value = "open-manipulator-x"))]
    pub robot: String,
    /// How the robot is read
    #[cfg_attr(feature = "clap", command(flatten))]
    pub robot_options: crate::arm::RobotOptions,
    /// Gain of the momentum observer [1/s], with a model by hysteron arm fit delan
    #[cfg_attr(feature = "clap", arg(long, value_name = "GAIN", default_value_t = 25.0, value_parser = crate::shared::number::gain))]
    pub gain: f64,
}

/// Carries out the verb.
///
/// # Errors
/// Bad input; files that cannot be written; arms that do not answer.
pub fn run(options: &Options, context: &Context) -> anyhow::Result<Value> {
    if options.live.is_none() && options.recording.is_none() {
        return Err(BadInput::new("arguments", "a recording or --live FILE", "neither").into());
    }
    let expected = "an actuator by hysteron arm fit neural, or a model by hysteron arm fit delan";
    arm::refuse_robot(&options.actuator, expected, "--robot takes the robot")?;
    if learned_dynamics::is_model(&options.actuator) {
        return external::run(options, context);
    }
    let read = [Some(&options.actuator), options.recording.as_ref(), options.live.as_ref()];
    let outputs = arm::reads(&options.robot).and(read.into_iter().flatten().cloned());
    let outputs = outputs.recording("--out", &options.out);
    // A recording from a bus has a lock of its own.
    let _claim = options.live.is_none().then(|| outputs.check(context)).transpose()?;
    let actuator = NeuralActuator::read(&options.actuator)?;
    let model = actuator.observed_arm(&options.robot_options.model(&options.robot, context)?)?;
    let estimator = Estimator::new(&actuator, &model);
    let estimator = estimator.map_err(|bad| bad.within(options.actuator.display()))?;
    match (&options.live, &options.recording) {
        (Some(arms), _) => live::run((options, arms), &actuator, estimator, context),
        (None, Some(recording)) => along((options, recording), &actuator, estimator, context),
        (None, None) => Ok(Value::Null),
    }
}

/// Channels of the estimates, for `m` motors.
fn names(m: usize) -> Vec<String> {
    let torques = (1..=m).map(|k| format!("torque_{k}_n_m"));
    let rest = ["force_x_n", "force_y_n", "force_z_n", "contact_ratio", "healthy_ratio"];
    torques.chain(rest.map(String::from)).collect()
}

/// Their values in that order.
fn values<'a>(torque: &'a [f64], now: &SensedNow) -> impl Iterator<Item = f64> + use<'a> {
    let SensedNow { force: [x, y, z], gate, condition } = *now;
    torque.iter().copied().chain([x, y, z, gate, condition])
}

/// Estimates along a recording.
fn along(
    (options, path): (&Options, &PathBuf),
    actuator: &NeuralActuator,
    estimator: Estimator<'_>,
    context: &Context,
) -> anyhow::Result<Value> {
    let (features, period) = (&actuator.features, actuator.simulation.period);
    let within = |bad: BadInput| bad.within(path.display());
    let recording = Recording::read(path)?;
    let trajectory = trajectory_of(&recording, features, period, Unlabelled::Unknown).map_err(within)?;
    let voltage = trajectory.motor_voltage().map_err(within)?;
    let mut estimator = estimator.with_position_gain(trajectory.position_gain).map_err(within)?;
    let (n, names) = (features.joints, names(features.motors()));
    let mut columns = vec![Vec::with_capacity(trajectory.len()); names.len()];
    let (mut contacts, mut healthy) = (0, f64::NAN);
    for row in 0..trajectory.len() {
        let [inputs, state] = [trajectory.inputs_at(row as isize), trajectory.state_at(row)];
        let now = estimator.update_inputs([inputs, state, &voltage[row * n..][..n]]);
        let all = values(estimator.torque(), &now);
        columns.iter_mut().zip(all).for_each(|(column, value)| column.push(value));
        contacts += usize::from(now.gate >= 0.5);
        healthy = now.condition;
    }
    let channels = names.into_iter().zip(columns).map(|(name, column)| Channel::new(name, column)).collect();
    let begin = recording.time().first().copied().unwrap_or(0.0);
    let time = (0..trajectory.len()).map(|row| begin + period * row as f64).collect();
    let meta = arm::meta(context, "torques, force, contact and condition from telemetry");
    Recording::new(time, channels, trajectory.gap.clone(), meta)?.write(&options.out)?;
    let share = contacts as f64 / trajectory.len() as f64;
    context.print(format_args!(
        "{} rows, contact in {:.1} % of them, condition at the end {healthy:.3}: {}",
        trajectory.len(),
        100.0 * share,
        options.out.display()
    ));
    Ok(json!({ "rows": trajectory.len(), "contact": share, "healthy_at_end": healthy, "out": options.out }))
}
