//! `hysteron arm dynamics`: every quantity of rigid-body dynamics, for every row of states.

use std::path::PathBuf;

use hysteron_arm::{Wanted, dynamics_of_rows};
use hysteron_base::Recording;
use serde_json::{Value, json};

use crate::Caller;

/// Compute the dynamics of every row of states
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    /// File of URDF or MJCF, or name of a built-in robot
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
    let model = super::model(&options.model)?;
    let frame = super::frame(&model, options.frame.as_deref())?;
    let wanted = Wanted { frame, derivatives: options.derivatives };
    let states = Recording::read(&options.states)?;
    let outputs = super::reads(&options.model).and([&options.states]).file("--out", &options.out);
    let _claim = outputs.check(caller)?;
    let results = dynamics_of_rows(&model, &states, wanted, super::meta(caller, "rigid-body dynamics"))
        .map_err(|bad| bad.within(options.states.display()))?;
    results.write(&options.out)?;
    caller.say(format_args!("{} rows: {}", results.n_samples(), options.out.display()));
    Ok(json!({ "rows": results.n_samples(), "out": options.out }))
}
