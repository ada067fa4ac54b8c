//! `hysteron arm evaluate`: a learned model, of inverse dynamics or of actuators, beside recordings.

use std::path::PathBuf;

use hysteron_arm::lagrangian::{LearnedDynamics, Scores, samples_of};
use hysteron_arm::neural::NeuralActuator;
use hysteron_arm::{Quantity, Recorded};
use hysteron_base::checks::{CheckContext, Purpose};
use hysteron_base::{BadInput, Channel, Recording, json};
use hysteron_learn::read_parameters_header;
use serde_json::Value;

use super::neural_evaluate::{self, Places};
use crate::shared::outputs::Outputs;
use crate::{Context, arm, shared::recording_checks};

/// Compare the predictions of a learned model with recordings
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    /// Model by hysteron arm fit
    pub model: PathBuf,
    /// Recordings to compare with: one for a model of inverse dynamics; for a neural actuator any number, or folders, of which what
    /// is called train or validation is left out
    #[cfg_attr(feature = "clap", arg(required = true, value_name = "REC"))]
    pub recordings: Vec<PathBuf>,
    /// Where the parts of the torque go, .csv or .parquet; of a neural actuator, every number as JSON
    #[cfg_attr(feature = "clap", arg(long, value_name = "FILE"))]
    pub out: Option<PathBuf>,
    /// Folder for report.html and metrics.json, of a neural actuator
    #[cfg_attr(feature = "clap", arg(long, value_name = "DIR"))]
    pub figures: Option<PathBuf>,
    /// The arm of a neural actuator: a file of URDF or MJCF, or a built-in name
    #[cfg_attr(feature = "clap", arg(long, value_name = "MODEL", default_value = "open-manipulator-x"))]
    pub robot: String,
    /// How the robot is read
    #[cfg_attr(feature = "clap", command(flatten))]
    pub robot_options: arm::RobotOptions,
    /// Without recordings whose path contains this; may be repeated
    #[cfg_attr(feature = "clap", arg(long, value_name = "TEXT"))]
    pub leave_out: Vec<String>,
    /// Recordings whose path contains this move freely: a sample without label of force is one of no force; may be repeated
    #[cfg_attr(feature = "clap", arg(long, value_name = "TEXT", default_value = "force_unlabeled"))]
    pub free: Vec<String>,
    /// Recordings or folders to which detectors of a degraded motor are fitted, to stand beside the network
    #[cfg_attr(feature = "clap", arg(long, value_name = "REC", num_args = 1..))]
    pub detectors: Vec<PathBuf>,
    /// Velocities above this are noise, where accelerations are differences of them
    #[cfg_attr(feature = "clap", arg(long, value_name = "HZ", default_value_t = 10.0, value_parser = crate::shared::number::cutoff_hz))]
    pub cutoff: f64,
}

/// Carries out the verb.
///
/// # Errors
/// Bad input; files that cannot be written.
pub fn run(options: &Options, context: &Context) -> anyhow::Result<Value> {
    arm::refuse_robot(&options.model, "a model by hysteron arm fit", "--robot takes the robot")?;
    if read_parameters_header(&options.model)?.0 != NeuralActuator::KIND {
        return inverse_dynamics(options, context);
    }
    let actuator = NeuralActuator::read(&options.model)?;
    let places = Places {
        recordings: &options.recordings,
        leave_out: &options.leave_out,
        detectors: &options.detectors,
        free: &options.free,
        model: &options.robot,
        robot_options: &options.robot_options,
        out: options.out.as_deref(),
        figures: options.figures.as_deref(),
    };
    neural_evaluate::run(&actuator, &places, context)
}

fn inverse_dynamics(options: &Options, context: &Context) -> anyhow::Result<Value> {
    let [path] = &options.recordings[..] else {
        let found = options.recordings.len().to_string();
        return Err(BadInput::new("recordings", "one, for a model of inverse dynamics", found).into());
    };
    let outputs = Outputs::reading([&options.model, path]);
    let outputs = options.out.iter().fold(outputs, |outputs, out| outputs.recording("--out", out));
    let _claim = outputs.check(context)?;
    let model = LearnedDynamics::read(&options.model)?;
    let recording = Recording::read(path)?;
    let name = recording_checks::name_of(path);
    let findings = recording_checks::of_named(&[(&name, &recording)], &CheckContext::new(Purpose::Score))?;
    let within = |bad: BadInput| bad.within(path.display());
    let samples = samples_of(&recording, options.cutoff).map_err(within)?;
    let parts = model.decompose(&samples).map_err(within)?;
    let n = samples.n_joints;
    if let Some(k) = parts.torque.iter().position(|torque| !torque.is_finite()) {
        let place = format!("{}: sample {}: torque of joint {}", path.display(), k / n + 1, k % n + 1);
        let bad = BadInput::new(place, "a finite number from the model", parts.torque[k].to_string());
        return Err(bad.hint("the model diverges on this recording: is it of the same arm?").into());
    }
    let scores = Scores::of(n, &samples.tau, &parts.torque);
    for j in 0..n {
        context.print(format_args!(
            "joint {}: mean squared error {:.4e}, over the variance {:.4e}",
            j + 1,
            scores.mse[j],
            scores.nmse[j]
        ));
    }
    context.print(format_args!(
        "R² pooled {:.4}, mean of the joints {:.4}",
        scores.pooled_r2,
        scores.mean_r2()
    ));
    let summary = json!({
        "mse_n2_m2": scores.mse, "nmse": scores.nmse, "pooled_r2": scores.pooled_r2, "mean_r2": scores.mean_r2(),
        "recording_warnings": findings,
    });
    let Some(out) = &options.out else { return Ok(summary) };
    let recorded = Recorded::of(&recording).map_err(within)?;
    let kept: Vec<bool> = recorded.gap.iter().map(|gap| !gap).collect();
    let time: Vec<f64> =
        recorded.time.iter().zip(&kept).filter(|(_, kept)| **kept).map(|(t, _)| *t).collect();
    let sets = [&parts.torque, &parts.inertial, &parts.coriolis, &parts.gravity, &parts.other];
    let mut channels = Vec::new();
    for (name, values) in ["tau", "inertial", "coriolis", "gravity", "other"].into_iter().zip(sets) {
        for (j, joint) in recorded.joints.iter().enumerate() {
            let torque = Quantity::Torque.channel(joint.kind, j);
            let column = values.iter().skip(j).step_by(n).copied().collect();
            channels.push(Channel::new(torque.replacen("tau", name, 1), column));
        }
    }
    let gap = vec![false; time.len()];
    let meta = arm::meta(context, "learned inverse dynamics");
    Recording::new(time, channels, gap, meta)?.write(out)?;
    context.print(format_args!("{} rows: {}", samples.len(), out.display()));
    Ok(summary)
}
