//! `hysteron arm identify`: bodies and friction of an arm from recordings of it.

use std::path::PathBuf;

use hysteron_actuator::identify::identify_friction;
use hysteron_actuator::law::{LAW_NAMES, Law};
use hysteron_arm::identify::{BodyOptions, Determined, JointMotion, JointTerm, identify_bodies};
use hysteron_arm::{Quantity, Recorded};
use hysteron_base::{BadInput, Recording, file};
use hysteron_workflow::outputs::Outputs;
use hysteron_workflow::{COMMIT, Caller};
use serde_json::{Value, json};

use crate::terminal::say;

const INERTIA_HELP: &str = "\
Needs recordings (.csv or .parquet) with time_s at a fixed rate and q_k_rad, tau_k_n_m of every joint, and dq_k_rad_s if measured; \
`hysteron arm import` makes them of other programs' files. The robot's file says where the joints are and what is believed of its \
bodies.

Found are the ten numbers of every body, so that it can exist, and of every joint armature, Coulomb and viscous friction, offset of \
the torque and a spring. Each has a standard error; \"together\" marks what the motion determines only in sums with others.

Writes estimates and errors to a file of JSON.

Exit codes: 0 done, 1 failed, 2 bad input (nothing is written).";

const FRICTION_HELP: &str = "\
Needs recordings (.csv or .parquet) with dq_k_rad_s and tau_k_n_m: torques from which weight and inertia are gone, of steady motions \
for example. Fits a law of friction and an offset to one joint.

Writes parameters with standard errors to a file of JSON.

Exit codes: 0 done, 1 failed, 2 bad input (nothing is written).";

/// Identify an arm from recordings of it
#[derive(Debug, clap::Args)]
pub struct Arguments {
    #[command(subcommand)]
    what: What,
}

#[derive(Debug, clap::Subcommand)]
enum What {
    Inertia(InertiaArguments),
    Friction(FrictionArguments),
}

/// Bodies, rotors and friction of all joints
#[derive(Debug, clap::Args)]
#[command(after_help = INERTIA_HELP)]
struct InertiaArguments {
    /// File of URDF or MJCF, or name of a built-in robot
    model: String,
    /// Recordings to fit
    #[arg(required = true, value_name = "REC")]
    recordings: Vec<PathBuf>,
    /// Recording that is not fitted, to test on
    #[arg(long, value_name = "REC")]
    test: Option<PathBuf>,
    /// File of JSON to write
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// What is faster counts as noise
    #[arg(long, value_name = "HZ", default_value_t = 8.0)]
    cutoff: f64,
    /// Speed within which Coulomb friction changes its sign
    #[arg(long, value_name = "RAD_S", default_value_t = 0.05)]
    width: f64,
    /// Weight of the bodies in the robot's file, in samples
    #[arg(long, value_name = "N", default_value_t = 1.0)]
    prior: f64,
}

/// A law of friction of one joint
#[derive(Debug, clap::Args)]
#[command(after_help = FRICTION_HELP)]
struct FrictionArguments {
    /// Recordings to fit
    #[arg(required = true, value_name = "REC")]
    recordings: Vec<PathBuf>,
    /// Number of the joint, from 1
    #[arg(long, value_name = "K", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=64))]
    joint: u16,
    /// coulomb-viscous, stribeck or directed-stribeck
    #[arg(long, value_name = "NAME", default_value = "stribeck")]
    law: String,
    /// Error from which on a sample counts linearly rather than squared
    #[arg(long, value_name = "N_M")]
    huber: Option<f64>,
    /// File of JSON to write
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
}

const TERMS: [JointTerm; 5] =
    [JointTerm::Armature, JointTerm::Coulomb, JointTerm::Viscous, JointTerm::Offset, JointTerm::Spring];
/// Order of the low pass.
const ORDER: usize = 4;
/// Laws that need no torques through the gear.
const LAWS_OF_SPEED: usize = 3;

/// Carries out the verb.
pub fn run(arguments: &Arguments, caller: &Caller) -> anyhow::Result<Value> {
    match &arguments.what {
        What::Inertia(arguments) => inertia(arguments, caller),
        What::Friction(arguments) => friction(arguments, caller),
    }
}

fn inertia(arguments: &InertiaArguments, caller: &Caller) -> anyhow::Result<Value> {
    let model = super::model(&arguments.model)?;
    let outputs = super::reads(&arguments.model).and(&arguments.recordings).and(&arguments.test);
    let _claim = outputs.file("--out", &arguments.out).check(caller)?;
    let read = |path: &PathBuf| -> anyhow::Result<JointMotion> {
        let recording = Recording::read(path)?;
        let motion = Recorded::of(&recording)
            .and_then(|recorded| JointMotion::of_recording(&recorded, ORDER, arguments.cutoff));
        Ok(motion.map_err(|bad| bad.within(path.display()))?)
    };
    let mut motion = read(&arguments.recordings[0])?;
    for path in &arguments.recordings[1..] {
        let more = read(path)?;
        if more.n_joints != motion.n_joints {
            let expected = format!("{} joints, as the first recording has", motion.n_joints);
            return Err(BadInput::new(path.display().to_string(), expected, more.n_joints.to_string()).into());
        }
        motion.extend(&more);
    }
    let test = arguments.test.as_ref().map(read).transpose()?;
    let options = BodyOptions { terms: &TERMS, width: arguments.width, prior: arguments.prior };
    let fit = identify_bodies(&model, &motion, &options)?;
    let tested = match &test {
        Some(test) if test.n_joints != model.n_joints() => {
            let expected = format!("{} joints", model.n_joints());
            return Err(BadInput::new("--test", expected, test.n_joints.to_string()).into());
        }
        test => test.as_ref().map(|test| fit.rms_on(test)),
    };
    say("number                                          value      standard error");
    for estimate in &fit.estimates {
        let mark = if estimate.determined == Determined::Together { "together" } else { "" };
        say(format_args!(
            "{:<40} {:>12.5} {:>14.2e}   {mark}",
            estimate.name, estimate.value, estimate.standard_error
        ));
    }
    say(format_args!("error of the torques, RMS by joint [N m]: {:.4?}", fit.rms));
    if let Some(tested) = &tested {
        say(format_args!("on the recording that was not fitted: {tested:.4?}"));
    }
    say(format_args!("{} combinations determined, condition {:.0}", fit.n_determined, fit.condition));
    fit.warnings.iter().for_each(say);
    let estimates: Vec<Value> = (fit.estimates.iter())
        .map(|e| {
            let alone = e.determined == Determined::Alone;
            json!({"name": e.name, "value": e.value, "standard_error": e.standard_error, "determined_alone": alone})
        })
        .collect();
    let found = json!({
        "format": "hysteron-identification", "version": 1, "robot": model.name(), "estimates": estimates,
        "rms_n_m": fit.rms, "test_rms_n_m": tested, "n_determined": fit.n_determined, "condition": fit.condition,
        "warnings": fit.warnings, "samples": motion.n_samples(), "cutoff_hz": arguments.cutoff,
        "command": caller.command, "commit": COMMIT,
    });
    file::write_bytes(&arguments.out, serde_json::to_vec_pretty(&found)?)?;
    Ok(found)
}

fn friction(arguments: &FrictionArguments, caller: &Caller) -> anyhow::Result<Value> {
    if !LAW_NAMES[..LAWS_OF_SPEED].contains(&arguments.law.as_str()) {
        let expected = format!("one of {}", LAW_NAMES[..LAWS_OF_SPEED].join(", "));
        return Err(BadInput::new("--law", expected, format!("{:?}", arguments.law)).into());
    }
    if arguments.huber.is_some_and(|huber| !huber.is_finite() || huber <= 0.0) {
        return Err(BadInput::new("--huber", "a torque above 0", format!("{:?}", arguments.huber)).into());
    }
    let law = Law::named(&arguments.law)?;
    let outputs = Outputs::reading(&arguments.recordings).file("--out", &arguments.out);
    let _claim = outputs.check(caller)?;
    let (mut speeds, mut torques) = (Vec::new(), Vec::new());
    for path in &arguments.recordings {
        let recording = Recording::read(path)?;
        let within = |bad: BadInput| bad.within(path.display());
        let recorded = Recorded::of(&recording).map_err(within)?;
        let joint = usize::from(arguments.joint) - 1;
        let column = |quantity| -> Result<Vec<f64>, BadInput> {
            let columns = recorded.require(quantity)?;
            let column = columns.get(joint).ok_or_else(|| {
                BadInput::new("--joint", format!("1 to {}", columns.len()), arguments.joint.to_string())
            })?;
            Ok(column.to_vec())
        };
        speeds.extend(column(Quantity::Velocity).map_err(within)?);
        torques.extend(column(Quantity::Torque).map_err(within)?);
    }
    let found = identify_friction(&law, &speeds, &torques, arguments.huber)?;
    say("parameter                                value      standard error");
    for estimate in &found.fit.estimates {
        let error = estimate.standard_error.map_or_else(|| "-".to_owned(), |error| format!("{error:.2e}"));
        say(format_args!(
            "{:<34} {:>12.5} {error:>16}   {:?}",
            estimate.name, estimate.value, estimate.standing
        ));
    }
    say(format_args!("error {:.4} N m RMS, condition {:.0}", found.fit.rms[1], found.fit.condition));
    let estimates: Vec<Value> = (found.fit.estimates.iter())
        .map(|e| {
            json!({"name": e.name, "value": e.value, "standard_error": e.standard_error, "standing": format!("{:?}", e.standing)})
        })
        .collect();
    let summary = json!({
        "format": "hysteron-identification", "version": 1, "law": arguments.law, "joint": arguments.joint,
        "estimates": estimates, "correlation": found.fit.correlation, "rms_n_m": found.fit.rms[1],
        "condition": found.fit.condition, "samples": speeds.len(), "command": caller.command, "commit": COMMIT,
    });
    file::write_bytes(&arguments.out, serde_json::to_vec_pretty(&summary)?)?;
    Ok(summary)
}
