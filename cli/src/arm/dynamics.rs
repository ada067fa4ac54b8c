//! `hysteron arm dynamics`: every quantity of rigid-body dynamics, for every row of states.

use std::path::PathBuf;

use hysteron_arm::{Wanted, dynamics_of_rows};
use hysteron_base::Recording;
use hysteron_workflow::Caller;

use crate::terminal::say;

const HELP: &str = "\
Needs a recording (.csv or .parquet) with time_s, q_1_rad, …, dq_1_rad_s, … and either ddq_1_rad_s2, … (then torques are \
computed) or tau_1_n_m, … (then accelerations are); joints that slide have _m, _m_s, _m_s2 and _n. Degrees do in a CSV.

Writes a recording: these, and the mass matrix, Coriolis torque, gravity, position and Jacobian of a frame, energies; with \
--derivatives those of the torques by coordinates and speeds (tau_1_by_q_2_n_m_per_rad, …), or of the accelerations by coordinates, \
speeds and torques (ddq_1_by_tau_2_rad_s2_per_n_m, …).

Exit codes: 0 done, 1 failed, 2 bad input (nothing is written).";

/// Compute the dynamics of every row of states
#[derive(Debug, clap::Args)]
#[command(after_help = HELP)]
pub struct Arguments {
    /// File of URDF or MJCF, or name of a built-in robot
    model: String,
    /// States, .csv or .parquet
    #[arg(long, value_name = "REC")]
    states: PathBuf,
    /// Where the results go, .csv or .parquet
    #[arg(long, value_name = "REC")]
    out: PathBuf,
    /// Frame whose position and Jacobian are wanted [default: the last of the robot]
    #[arg(long, value_name = "NAME")]
    frame: Option<String>,
    /// All derivatives too
    #[arg(long)]
    derivatives: bool,
}

/// Carries out the verb.
pub fn run(arguments: &Arguments, caller: &Caller) -> anyhow::Result<()> {
    let model = super::model(&arguments.model)?;
    let frame = super::frame(&model, arguments.frame.as_deref())?;
    let wanted = Wanted { frame, derivatives: arguments.derivatives };
    let states = Recording::read(&arguments.states)?;
    let outputs = super::reads(&arguments.model).and([&arguments.states]).file("--out", &arguments.out);
    let _claim = outputs.check(caller)?;
    let results = dynamics_of_rows(&model, &states, wanted, super::meta("rigid-body dynamics"))
        .map_err(|bad| bad.within(arguments.states.display()))?;
    results.write(&arguments.out)?;
    say(format_args!("{} rows: {}", results.n_samples(), arguments.out.display()));
    Ok(())
}
