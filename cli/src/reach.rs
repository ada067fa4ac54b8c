//! `hysteron reach`: the strokes that bring the tip to recorded goals, sample by sample.

use std::path::PathBuf;

use crate::number;
use crate::run::{Options, Task, carry_out};

const HELP: &str = "\
Needs a scene and a recording (.parquet or .csv) with the columns time_s, tip_x_mm, tip_y_mm and tip_z_mm (in Parquet \
tip_x_m, ...): what `hysteron simulate` writes will do. The strokes of all tendons of the scene are chosen, whatever \
drives them otherwise, within tension_min_n to tension_max_n and stroke_min_mm to stroke_max_mm. Where several choices \
reach the goal, the one with small tensions is taken. Virtual tendons follow aux_01_mm, ... if there, and rest \
otherwise.

Writes a recording: time, strokes, tensions, the tip as reached, and tip_error_m, its distance from the goal. Given \
to `hysteron simulate --strokes`, it brings the tip to the same places. A goal out of reach is no error: the tip comes \
as near as the bounds let it, and the end of the run says how many there were and the largest distance. A run that \
fails or is stopped with Ctrl-C writes OUT.partial.EXT and OUT.state instead; run it again with --resume to go on from \
there.

Example, from the root of the repository: goals from a simulation, and back to strokes
  hysteron simulate meshes/tpu80/scene.toml \\
      --strokes meshes/tpu80/strokes-circle.csv \\
      --out out/tpu80/tip.parquet
  hysteron reach meshes/tpu80/scene.toml \\
      --goals out/tpu80/tip.parquet \\
      --out out/tpu80/strokes.parquet --figures out/tpu80/reach

Exit codes: 0 done, 1 failed or interrupted, 2 bad input (nothing is written under the final name).";

/// Find the strokes that bring the tip to recorded goals
///
/// The inverse of `simulate`: for every sample, the strokes whose equilibrium has the tip at the goal, found from the
/// shape before.
#[derive(Debug, clap::Args)]
#[command(after_help = HELP)]
pub struct Arguments {
    /// Recording with the tip positions to reach, .parquet or .csv
    #[arg(long, value_name = "REC")]
    goals: PathBuf,
    /// Distance that counts as reached
    #[arg(long, value_name = "MM", default_value_t = 0.01, value_parser = number::length_mm)]
    tolerance_mm: f64,
    #[command(flatten)]
    options: Options,
}

/// Carries out the verb.
pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let tolerance = 1e-3 * arguments.tolerance_mm;
    carry_out(Task::Reach(tolerance), &arguments.goals, &arguments.options, None)
}
