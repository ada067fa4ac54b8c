//! `hysteron arm dynamics`: every quantity of rigid-body dynamics, for every row of states.

use std::path::{Path, PathBuf};

use hysteron_arm::{JointKind, Model, Quantity, Wanted, columns_of_dynamics, dynamics_of_rows};
use hysteron_base::{BadInput, MAX_CHANNELS, Recording};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::Context;
use crate::arm::learned_dynamics;
use crate::shared::outputs::Outputs;

/// Compute the dynamics of every row of states
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    /// File of URDF or MJCF, name of a built-in robot, or model by hysteron arm fit delan
    pub model: String,
    /// How the robot is read
    #[cfg_attr(feature = "clap", command(flatten))]
    pub robot_options: super::RobotOptions,
    /// States, .csv or .parquet
    #[cfg_attr(feature = "clap", arg(long, value_name = "REC"))]
    pub states: PathBuf,
    /// Where the results go, .csv or .parquet
    #[cfg_attr(feature = "clap", arg(long, value_name = "REC"))]
    pub out: PathBuf,
    /// Frame whose position and Jacobian are wanted [default: the last of the robot]
    #[cfg_attr(feature = "clap", arg(long, value_name = "NAME"))]
    pub frame: Option<String>,
    /// All derivatives too
    #[cfg_attr(feature = "clap", arg(long))]
    pub derivatives: bool,
}

/// The outcome of `arm dynamics`.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Outcome {
    /// Number of samples.
    pub rows: usize,
    /// The recording of the results.
    pub out: PathBuf,
}

impl crate::shared::outcome::Outcome for Outcome {}

/// Carries out the verb.
///
/// # Errors
/// Bad input; files that cannot be written.
pub fn run(options: &Options, context: &Context) -> anyhow::Result<Outcome> {
    if learned_dynamics::is_model(options.model.as_ref()) {
        return learned(options, context);
    }
    let states = Recording::read(&options.states)?;
    // Torques follow from accelerations whatever the masses are; the other way round M has to be definite.
    let is_inverse =
        [Quantity::Torque.channel(JointKind::Revolute, 0), Quantity::Torque.channel(JointKind::Prismatic, 0)]
            .iter()
            .all(|name| states.channel(name).is_none());
    let model = match is_inverse {
        true => options.robot_options.model_of_any_mass(&options.model, context)?,
        false => options.robot_options.model(&options.model, context)?,
    };
    let frame = super::frame(&model, options.frame.as_deref())?;
    check_columns(&model, options, is_inverse)?;
    let wanted = Wanted { frame, derivatives: options.derivatives };
    let outputs = super::reads(&options.model).and([&options.states]).recording("--out", &options.out);
    let _claim = outputs.check(context)?;
    let results = dynamics_of_rows(&model, &states, wanted, super::meta(context, "rigid-body dynamics"))
        .map_err(|bad| bad.within(options.states.display()))?;
    written(&results, options, context)
}

/// Refuses robots whose derivatives do not fit in a recording, with the number of joints that do.
fn check_columns(model: &Model, options: &Options, is_inverse: bool) -> Result<(), BadInput> {
    let of = |n: usize| columns_of_dynamics(n, options.derivatives, is_inverse);
    if of(model.n_joints()) <= MAX_CHANNELS {
        return Ok(());
    }
    let most = (1..=model.n_joints()).take_while(|n| of(*n) <= MAX_CHANNELS).count();
    let option = if options.derivatives { "--derivatives" } else { "MODEL" };
    let expected =
        format!("a robot of at most {most} joints: a recording has at most {MAX_CHANNELS} columns");
    let found = format!("{} joints, whose dynamics have {} columns", model.n_joints(), of(model.n_joints()));
    let hint = match options.derivatives {
        true => "without --derivatives it has fewer; joints that are fixed in the file do not count",
        false => "joints that are fixed in the file do not count",
    };
    Err(BadInput::new(option, expected, found).hint(hint))
}

/// Torques of a learned model for the same states.
fn learned(options: &Options, context: &Context) -> anyhow::Result<Outcome> {
    if options.derivatives || options.frame.is_some() {
        let option = if options.derivatives { "--derivatives" } else { "--frame" };
        let bad = BadInput::new(option, "a robot file", "a learned model, which has torques alone");
        return Err(bad.into());
    }
    let outputs =
        Outputs::reading([Path::new(&options.model), &options.states]).recording("--out", &options.out);
    let _claim = outputs.check(context)?;
    let states = Recording::read(&options.states)?;
    let meta = super::meta(context, "learned inverse dynamics");
    let found = learned_dynamics::torques(options.model.as_ref(), (&options.states, &states), meta)?;
    written(&found, options, context)
}

fn written(results: &Recording, options: &Options, context: &Context) -> anyhow::Result<Outcome> {
    results.write(&options.out)?;
    context.print(format_args!("{} rows: {}", results.n_samples(), options.out.display()));
    Ok(Outcome { rows: results.n_samples(), out: options.out.clone() })
}
