//! `hysteron arm simulate`: the motion of an arm under recorded torques.

use std::path::PathBuf;

use hysteron_arm::{Model, Quantity, joint_rows, motion_under_torques};
use hysteron_base::{BadInput, Recording};
use hysteron_workflow::{Caller, arm_figures};

use crate::terminal::say;

const HELP: &str = "\
Needs a recording (.csv or .parquet) with time_s and tau_1_n_m, … of every joint (tau_k_n where it slides). Each torque holds until \
the next row. Damping, dry friction, armature and ranges are those of the robot's file.

Writes a recording: torques, q_1_rad, …, dq_1_rad_s, …, and energies; and with --figures joints, torques and what they are spent \
on, energies, and the arm at several times.

Example, from the root of the repository:
  hysteron arm simulate three-link --torques arm/tests/data/torques.csv --start 0.3,-0.4,0.5 \\
      --out out/arm/motion.csv --figures out/arm

Exit codes: 0 done, 1 failed, 2 bad input (nothing is written).";

/// Simulate the motion of an arm under recorded torques
#[derive(Debug, clap::Args)]
#[command(after_help = HELP)]
pub struct Arguments {
    /// File of URDF or MJCF, or name of a built-in robot
    model: String,
    /// Torques, .csv or .parquet
    #[arg(long, value_name = "REC")]
    torques: PathBuf,
    /// Where the motion goes, .csv or .parquet
    #[arg(long, value_name = "REC")]
    out: PathBuf,
    /// Coordinates at the start, in rad or m [default: those of the first row of REC, where it has them, else zero]
    #[arg(long, value_name = "Q,...", value_delimiter = ',', allow_negative_numbers = true)]
    start: Vec<f64>,
    /// Equal parts of the time between two rows
    #[arg(long, value_name = "N", default_value = "4", value_parser = clap::value_parser!(u16).range(1..=1000))]
    substeps: u16,
    /// Folder for figures, report.html and metrics.json
    #[arg(long, value_name = "DIR")]
    figures: Option<PathBuf>,
    /// Write each figure as .png too
    #[arg(long, requires = "figures")]
    png: bool,
}

/// Carries out the verb.
pub fn run(arguments: &Arguments, caller: &Caller) -> anyhow::Result<()> {
    let model = super::model(&arguments.model)?;
    let torques = Recording::read(&arguments.torques)?;
    let outputs = super::reads(&arguments.model).and([&arguments.torques]).file("--out", &arguments.out);
    let _claim = outputs.report("--figures", arguments.figures.as_deref()).check(caller)?;
    let start = match arguments.start.is_empty() {
        true => first_row(&model, &torques).map_err(|bad| bad.within(arguments.torques.display()))?,
        false => arguments.start.clone(),
    };
    let motion = motion_under_torques(
        &model,
        &torques,
        &start,
        usize::from(arguments.substeps),
        super::meta("rigid-body simulation"),
    )
    .map_err(|bad| bad.within(arguments.torques.display()))?;
    motion.write(&arguments.out)?;
    if let Some(folder) = &arguments.figures {
        arm_figures::write(folder, &model, &motion, arguments.png)?;
    }
    say(format_args!("{} rows: {}", motion.n_samples(), arguments.out.display()));
    Ok(())
}

/// Coordinates of the first row; zero where there are none.
fn first_row(model: &Model, recording: &Recording) -> Result<Vec<f64>, BadInput> {
    let n = model.n_joints();
    let rows = joint_rows(model, recording, Quantity::Position)?;
    Ok(rows.map_or_else(|| vec![0.0; n], |rows| rows[..n].to_vec()))
}
