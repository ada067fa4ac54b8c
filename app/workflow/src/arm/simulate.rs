//! `hysteron arm simulate`: the motion of an arm under recorded torques.

use std::path::PathBuf;

use hysteron_arm::{Model, Quantity, joint_rows, motion_under_torques};
use hysteron_base::{BadInput, Recording};

use crate::Context;
use crate::arm_figures::{self, Outcome};

/// Simulate the motion of an arm under recorded torques
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    /// File of URDF or MJCF, or name of a built-in robot
    pub model: String,
    /// How the robot is read
    #[cfg_attr(feature = "clap", command(flatten))]
    pub robot_options: super::RobotOptions,
    /// Torques, .csv or .parquet
    #[cfg_attr(feature = "clap", arg(long, value_name = "REC"))]
    pub torques: PathBuf,
    /// Where the motion goes, .csv or .parquet
    #[cfg_attr(feature = "clap", arg(long, value_name = "REC"))]
    pub out: PathBuf,
    /// Coordinates at the start, in rad or m [default: those of the first row of REC, where it has them, else zero]
    #[cfg_attr(
        feature = "clap",
        arg(long, value_name = "Q,...", value_delimiter = ',', allow_negative_numbers = true)
    )]
    pub start: Vec<f64>,
    /// Equal parts of the time between two rows
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value = "4", value_parser = clap::value_parser!(u16).range(1..=1000)))]
    pub substeps: u16,
    /// Folder for figures, report.html and metrics.json
    #[cfg_attr(feature = "clap", arg(long, value_name = "DIR"))]
    pub figures: Option<PathBuf>,
    /// Write each figure as .png too
    #[cfg_attr(feature = "clap", arg(long, requires = "figures"))]
    pub png: bool,
}

/// Carries out the verb.
///
/// # Errors
/// Bad input; files that cannot be written.
pub fn run(options: &Options, context: &Context) -> anyhow::Result<Outcome> {
    let model = options.robot_options.model(&options.model, context)?;
    let torques = Recording::read(&options.torques)?;
    let outputs = super::reads(&options.model).and([&options.torques]).recording("--out", &options.out);
    let _claim = outputs.report("--figures", options.figures.as_deref()).check(context)?;
    let start = match options.start.is_empty() {
        true => first_row(&model, &torques).map_err(|bad| bad.within(options.torques.display()))?,
        false => options.start.clone(),
    };
    let motion = motion_under_torques(
        &model,
        &torques,
        &start,
        usize::from(options.substeps),
        super::meta(context, "rigid-body simulation"),
    )
    .map_err(|bad| bad.within(options.torques.display()))?;
    motion.write(&options.out)?;
    let outcome = Outcome::new(&model, &motion)?;
    if let Some(folder) = &options.figures {
        arm_figures::write(folder, &model, &motion, &outcome, options.png)?;
    }
    context.print(format_args!("{} rows: {}", motion.n_samples(), options.out.display()));
    Ok(outcome)
}

/// Coordinates of the first row; zero where there are none.
fn first_row(model: &Model, recording: &Recording) -> Result<Vec<f64>, BadInput> {
    let n = model.n_joints();
    let rows = joint_rows(model, recording, Quantity::Position)?;
    Ok(rows.map_or_else(|| vec![0.0; n], |rows| rows[..n].to_vec()))
}
