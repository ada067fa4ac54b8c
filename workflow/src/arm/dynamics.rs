//! `hysteron arm dynamics`: every quantity of rigid-body dynamics, for every row of states.

use std::path::{Path, PathBuf};

use hysteron_arm::{Wanted, dynamics_of_rows};
use hysteron_base::{BadInput, Recording, json};
use serde_json::Value;

use crate::Caller;
use crate::learned_dynamics;
use crate::outputs::Outputs;

/// Compute the dynamics of every row of states
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    /// File of URDF or MJCF, name of a built-in robot, or model by hysteron arm fit delan
    pub model: String,
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

/// Carries out the verb.
///
/// # Errors
/// Bad input; files that cannot be written.
pub fn run(options: &Options, caller: &Caller) -> anyhow::Result<Value> {
    if learned_dynamics::is_model(options.model.as_ref()) {
        return learned(options, caller);
    }
    let model = super::model(&options.model)?;
    let frame = super::frame(&model, options.frame.as_deref())?;
    let wanted = Wanted { frame, derivatives: options.derivatives };
    let states = Recording::read(&options.states)?;
    let outputs = super::reads(&options.model).and([&options.states]).file("--out", &options.out);
    let _claim = outputs.check(caller)?;
    let results = dynamics_of_rows(&model, &states, wanted, super::meta(caller, "rigid-body dynamics"))
        .map_err(|bad| bad.within(options.states.display()))?;
    written(&results, options, caller)
}

/// Torques of a learned model for the same states.
fn learned(options: &Options, caller: &Caller) -> anyhow::Result<Value> {
    if options.derivatives || options.frame.is_some() {
        let option = if options.derivatives { "--derivatives" } else { "--frame" };
        let bad = BadInput::new(option, "a robot file", "a learned model, which has torques alone");
        return Err(bad.into());
    }
    let outputs = Outputs::reading([Path::new(&options.model), &options.states]).file("--out", &options.out);
    let _claim = outputs.check(caller)?;
    let states = Recording::read(&options.states)?;
    let meta = super::meta(caller, "learned inverse dynamics");
    let found = learned_dynamics::torques(options.model.as_ref(), (&options.states, &states), meta)?;
    written(&found, options, caller)
}

fn written(results: &Recording, options: &Options, caller: &Caller) -> anyhow::Result<Value> {
    results.write(&options.out)?;
    caller.say(format_args!("{} rows: {}", results.n_samples(), options.out.display()));
    Ok(json!({ "rows": results.n_samples(), "out": options.out }))
}
