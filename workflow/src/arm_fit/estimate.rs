//! `hysteron arm estimate`: force on the tip, contact and condition of a motor along a recording, or external torques, sample by sample.

use std::path::PathBuf;

use hysteron_arm::neural::{NeuralActuator, SensingRunner, Unlabelled, trajectory_of};
use hysteron_base::{BadInput, Channel, Recording};
use serde_json::{Value, json};

use crate::learned_dynamics;
use crate::outputs::Outputs;
use crate::{Caller, arm};

/// Estimate force, contact and motor condition along a recording from servo telemetry, or external torques with learned dynamics
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    /// Actuator by hysteron arm fit neural --sensing observer, or model by hysteron arm fit delan
    pub actuator: PathBuf,
    /// Recording of the arm
    #[cfg_attr(feature = "clap", arg(value_name = "REC"))]
    pub recording: PathBuf,
    /// Recording to write, .csv or .parquet
    #[cfg_attr(feature = "clap", arg(long, value_name = "FILE"))]
    pub out: PathBuf,
    /// The arm: a file of URDF or MJCF, or a built-in name
    #[cfg_attr(feature = "clap", arg(long, value_name = "MODEL", default_value = "open-manipulator-x"))]
    pub robot: String,
    /// Gain of the momentum observer [1/s], with a model by hysteron arm fit delan
    #[cfg_attr(feature = "clap", arg(long, value_name = "GAIN", default_value_t = 25.0))]
    pub gain: f64,
}

/// Carries out the verb.
///
/// # Errors
/// Bad input; files that cannot be written.
pub fn run(options: &Options, caller: &Caller) -> anyhow::Result<Value> {
    if learned_dynamics::is_model(&options.actuator) {
        return external(options, caller);
    }
    let read = [options.actuator.clone(), options.recording.clone()];
    let outputs = arm::reads(&options.robot).and(&read).file("--out", &options.out);
    let _claim = outputs.check(caller)?;
    let actuator = NeuralActuator::read(&options.actuator)?;
    let Some(sensing) = &actuator.sensing else {
        let expected = "an actuator that was trained with --sensing observer";
        return Err(BadInput::new(options.actuator.display().to_string(), expected, "--sensing loop")
            .hint("the network in the loop says force and condition in a simulation: hysteron arm evaluate")
            .into());
    };
    let model = actuator.observed_arm(&arm::model(&options.robot)?)?;
    let (features, period) = (&actuator.features, actuator.simulation.period);
    let within = |bad: BadInput| bad.within(options.recording.display());
    let recording = Recording::read(&options.recording)?;
    let trajectory = trajectory_of(&recording, features, period, Unlabelled::Unknown).map_err(within)?;
    let voltage = trajectory.motor_voltage().map_err(within)?;
    let mut runner = SensingRunner::new(sensing, &model, (features, period))?;
    let n = features.joints;
    let (mut columns, mut contacts) = ([(); 5].map(|()| Vec::with_capacity(trajectory.len())), 0);
    for row in 0..trajectory.len() {
        let [inputs, state] = [trajectory.inputs_at(row as isize), trajectory.state_at(row)];
        let now = runner.update([inputs, state, &voltage[row * n..][..n]]);
        let values = now.force.into_iter().chain([now.gate, now.condition]);
        columns.iter_mut().zip(values).for_each(|(column, value)| column.push(value));
        contacts += usize::from(now.gate >= 0.5);
    }
    let names = ["force_x_n", "force_y_n", "force_z_n", "contact_ratio", "healthy_ratio"];
    let healthy = columns[4].last().copied().unwrap_or(f64::NAN);
    let channels = names.into_iter().zip(columns).map(|(name, column)| Channel::new(name, column)).collect();
    let begin = recording.time().first().copied().unwrap_or(0.0);
    let time = (0..trajectory.len()).map(|row| begin + period * row as f64).collect();
    let meta = arm::meta(caller, "force, contact and condition from telemetry");
    Recording::new(time, channels, trajectory.gap.clone(), meta)?.write(&options.out)?;
    let share = contacts as f64 / trajectory.len() as f64;
    caller.say(format_args!(
        "{} rows, contact in {:.1} % of them, condition at the end {healthy:.3}: {}",
        trajectory.len(),
        100.0 * share,
        options.out.display()
    ));
    Ok(json!({ "rows": trajectory.len(), "contact": share, "healthy_at_end": healthy, "out": options.out }))
}

/// External torques by a momentum observer whose dynamics are learned.
fn external(options: &Options, caller: &Caller) -> anyhow::Result<Value> {
    let outputs = Outputs::reading([&options.actuator, &options.recording]).file("--out", &options.out);
    let _claim = outputs.check(caller)?;
    let recording = Recording::read(&options.recording)?;
    let meta = arm::meta(caller, "external torques from learned dynamics");
    let place = (&*options.recording, &recording);
    let found = learned_dynamics::external(&options.actuator, place, options.gain, meta)?;
    found.write(&options.out)?;
    let rows = found.n_samples();
    let rms: Vec<f64> = found
        .channels()
        .iter()
        .map(|channel| (channel.values.iter().map(|v| v * v).sum::<f64>() / rows as f64).sqrt())
        .collect();
    let spelled: Vec<String> = rms.iter().map(|rms| format!("{rms:.3}")).collect();
    caller.say(format_args!(
        "{rows} rows, root mean square of each joint {} N m: {}",
        spelled.join(", "),
        options.out.display()
    ));
    Ok(json!({ "rows": rows, "rms_n_m": rms, "out": options.out }))
}
