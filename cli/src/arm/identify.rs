//! `hysteron arm identify`: bodies, friction, servos and payloads of an arm from recordings of it.

use std::path::{Path, PathBuf};

use hysteron_workflow::Caller;
use hysteron_workflow::arm;
use hysteron_workflow::arm_identify::{
    MotionOptions, Results, friction, inertia, payload, servo, with_locked,
};
use serde_json::Value;

const INERTIA_HELP: &str = "\
Needs recordings (.csv or .parquet) with time_s at a fixed rate and q_k_rad, tau_k_n_m of every joint, and dq_k_rad_s if measured; \
`hysteron arm import` makes them of other programs' files. Currents do instead of torques where --torque-constants says what an \
ampere is worth. The robot's file says where the joints are and what is believed of its bodies.

Found are the ten numbers of every body, so that it can exist, and of every joint armature, Coulomb and viscous friction, offset of \
the torque and a spring. Each has a standard error; some are determined only together with others.

Examples:
  hysteron arm import panda-gaz/ --columns panda-gaz --rate 1000 --out panda.parquet
  hysteron arm identify inertia panda panda.parquet --lock panda_finger_joint1 --lock panda_finger_joint2 \\
      --hold-out 0.3 --out panda.json --figures panda

Writes estimates and errors to a file of JSON.

Exit codes: 0 done, 1 failed, 2 bad input (nothing is written).";

const FRICTION_HELP: &str = "\
Needs recordings (.csv or .parquet) with dq_k_rad_s and tau_k_n_m: torques from which weight and inertia are gone, of steady motions \
for example. Fits a law of friction and an offset to one joint.

least-squares gives standard errors; pso, de (populations), anfis and fnn (fuzzy networks to whose curves the law is fitted) stand \
beside it for comparison. With --folds every recording is left out once.

Writes parameters to a file of JSON.

Exit codes: 0 done, 1 failed, 2 bad input (nothing is written).";

const SERVO_HELP: &str = "\
Needs recordings of a servo that swings a weight on a rod (.csv, .parquet, or a log of bam, .json) with goal_1_rad and q_1_rad, and \
temperature_1_degc, voltage_1_v, torque_on_1_ratio where there are; notes mass_kg, length_m and position_gain, or the options.

The simulation is given the goals alone and starts where the recording does; motor, supply, winding, armature, friction and zero are \
those that bring it nearest to the measured motion. Where the recordings say nothing of a number it is held at the catalogue's.

Drives: mx-106, mx-64, sts3215, sts3250, xl330-m288, xl430-w250, xm430-w350, or a file of TOML like those in actuator/drives.

Writes estimates and errors to a file of JSON.

Exit codes: 0 done, 1 failed or interrupted, 2 bad input (nothing is written).";

const PAYLOAD_HELP: &str = "\
Needs recordings of the arm without the payload (--bare) and with it, as `arm identify inertia` reads them; the same motion serves \
best. The arm is identified from the first; what the torques are beyond it in the others is the payload's: mass, centre and moments \
in the axes of --frame, with standard errors, of a body that can exist.

Writes estimates and errors to a file of JSON.

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
    Servo(ServoArguments),
    Payload(PayloadArguments),
}

/// Where results go.
#[derive(Debug, clap::Args)]
struct ResultArguments {
    /// File of JSON to write
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// Folder for figures, report.html and metrics.json
    #[arg(long, value_name = "DIR")]
    figures: Option<PathBuf>,
    /// Write each figure as .png too
    #[arg(long, requires = "figures")]
    png: bool,
}

/// How motions of an arm are read.
#[derive(Debug, clap::Args)]
struct MotionArguments {
    /// What is faster counts as noise
    #[arg(long, value_name = "HZ", default_value_t = 8.0, allow_negative_numbers = true)]
    cutoff: f64,
    /// Torque for a current in every joint, where the recordings have currents
    #[arg(long, value_name = "N_M_PER_A,...", value_delimiter = ',', allow_negative_numbers = true)]
    torque_constants: Vec<f64>,
    /// Speed within which Coulomb friction changes its sign
    #[arg(long, value_name = "RAD_S", default_value_t = 0.05, allow_negative_numbers = true)]
    width: f64,
    /// Joint of the robot that the recordings leave out, at zero or at a coordinate
    #[arg(long, value_name = "NAME[=Q]")]
    lock: Vec<String>,
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
    /// Last part of the recordings that is not fitted, to test on
    #[arg(long, value_name = "PART", default_value_t = 0.0, allow_negative_numbers = true)]
    hold_out: f64,
    /// Weight of the bodies in the robot's file, in samples
    #[arg(long, value_name = "N", default_value_t = 1.0, allow_negative_numbers = true)]
    prior: f64,
    /// File for the robot as identified: .urdf, .xml (MJCF) or .csv (parameters)
    #[arg(long, value_name = "FILE")]
    robot: Option<PathBuf>,
    #[command(flatten)]
    motion: MotionArguments,
    #[command(flatten)]
    results: ResultArguments,
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
    /// least-squares, pso, de, anfis or fnn
    #[arg(long, value_name = "NAME", default_value = "least-squares")]
    method: String,
    /// Parts of the recordings of which each is left out once
    #[arg(long, value_name = "N")]
    folds: Option<usize>,
    /// Error from which on a sample counts linearly rather than squared
    #[arg(long, value_name = "N_M", allow_negative_numbers = true)]
    huber: Option<f64>,
    /// Seed of populations
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    #[command(flatten)]
    results: ResultArguments,
}

/// Motor, supply, heat and friction of a servo that swings a weight
#[derive(Debug, clap::Args)]
#[command(after_help = SERVO_HELP)]
struct ServoArguments {
    /// Recordings to fit
    #[arg(required = true, value_name = "REC")]
    recordings: Vec<PathBuf>,
    /// Recordings that are not fitted, to test on
    #[arg(long, value_name = "REC", num_args = 1..)]
    test: Vec<PathBuf>,
    /// Name of a drive, or a file of TOML
    #[arg(long, value_name = "DRIVE", default_value = "xl330-m288")]
    drive: String,
    /// Law of friction: coulomb-viscous, stribeck, directed-stribeck, m1 to m6 [default: the drive's]
    #[arg(long, value_name = "NAME")]
    law: Option<String>,
    /// Mass of the weight [default: the recordings say]
    #[arg(long, value_name = "KG", allow_negative_numbers = true)]
    mass_kg: Option<f64>,
    /// Distance of the weight from the axis [default: the recordings say]
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    length_m: Option<f64>,
    /// Proportional gain as the register has it [default: the recordings say]
    #[arg(long, value_name = "P", allow_negative_numbers = true)]
    gain: Option<f64>,
    /// Longest step of the simulation
    #[arg(long, value_name = "S", default_value_t = 1e-3, allow_negative_numbers = true)]
    step: f64,
    #[command(flatten)]
    results: ResultArguments,
}

/// What an arm carries
#[derive(Debug, clap::Args)]
#[command(after_help = PAYLOAD_HELP)]
struct PayloadArguments {
    /// File of URDF or MJCF, or name of a built-in robot
    model: String,
    /// Recordings with the payload
    #[arg(required = true, value_name = "REC")]
    recordings: Vec<PathBuf>,
    /// Recordings without
    #[arg(long, required = true, value_name = "REC", num_args = 1..)]
    bare: Vec<PathBuf>,
    /// Frame that holds the payload [default: the robot's last]
    #[arg(long, value_name = "NAME")]
    frame: Option<String>,
    /// File for the robot as identified: .urdf, .xml (MJCF) or .csv (parameters)
    #[arg(long, value_name = "FILE")]
    robot: Option<PathBuf>,
    #[command(flatten)]
    motion: MotionArguments,
    #[command(flatten)]
    results: ResultArguments,
}

impl From<&ResultArguments> for Results {
    fn from(a: &ResultArguments) -> Self {
        Self { out: a.out.clone(), figures: a.figures.clone(), png: a.png }
    }
}

impl From<&MotionArguments> for MotionOptions {
    fn from(a: &MotionArguments) -> Self {
        Self { cutoff: a.cutoff, torque_constants: a.torque_constants.clone(), width: a.width }
    }
}

/// The file of a robot, if it is none that is built in.
fn file(model: &str) -> Option<PathBuf> {
    Some(PathBuf::from(model)).filter(|path| Path::exists(path))
}

/// Carries out the verb.
pub fn run(arguments: &Arguments, caller: &Caller) -> anyhow::Result<Value> {
    match &arguments.what {
        What::Inertia(a) => {
            let options = inertia::Options {
                model: with_locked(&arm::model(&a.model)?, &a.motion.lock)?,
                model_file: file(&a.model),
                recordings: a.recordings.clone(),
                test: a.test.clone(),
                hold_out: a.hold_out,
                motion: (&a.motion).into(),
                prior: a.prior,
                robot: a.robot.clone(),
                results: (&a.results).into(),
            };
            inertia::run(&options, caller)
        }
        What::Friction(a) => {
            let options = friction::Options {
                recordings: a.recordings.clone(),
                joint: usize::from(a.joint),
                law: a.law.clone(),
                method: a.method.clone(),
                folds: a.folds,
                seed: a.seed,
                huber: a.huber,
                results: (&a.results).into(),
            };
            friction::run(&options, caller)
        }
        What::Servo(a) => {
            let options = servo::Options {
                recordings: a.recordings.clone(),
                test: a.test.clone(),
                drive: a.drive.clone(),
                law: a.law.clone(),
                mass: a.mass_kg,
                length: a.length_m,
                gain: a.gain,
                step: a.step,
                results: (&a.results).into(),
            };
            servo::run(&options, caller)
        }
        What::Payload(a) => {
            let options = payload::Options {
                model: with_locked(&arm::model(&a.model)?, &a.motion.lock)?,
                model_file: file(&a.model),
                bare: a.bare.clone(),
                loaded: a.recordings.clone(),
                frame: a.frame.clone(),
                robot: a.robot.clone(),
                motion: (&a.motion).into(),
                results: (&a.results).into(),
            };
            payload::run(&options, caller)
        }
    }
}
