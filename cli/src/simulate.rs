//! `hysteron simulate`: a robot follows recorded strokes, sample by sample.

use std::path::PathBuf;

use crate::run::{Options, Task, carry_out};

const HELP: &str = "\
Needs a scene and a recording (.parquet or .csv) with a column time_s and, for every tendon that the scene drives by \
stroke, stroke_1_mm, stroke_2_mm, ... in the scene's order (positive pulls). Tendons driven by tension follow \
tension_1_n, ... instead. Virtual tendons follow aux_01_mm, ... if there, and rest otherwise.

Writes a recording: time, commanded and measured strokes, tensions, tip position, and where it all comes from. A \
stroke that needs more than the tendon's largest tension, or has no equilibrium, ends the run. A run that fails or is \
stopped with Ctrl-C writes OUT.partial.EXT and OUT.state instead; run it again with --resume to go on from there.

Examples, from the root of the repository:
  hysteron simulate meshes/tpu80/scene.toml \\
      --strokes meshes/tpu80/strokes-circle.csv \\
      --out out/tpu80/tip.parquet --figures out/tpu80 --vtu out/tpu80/vtu
  hysteron simulate meshes/tpu80/scene.toml \\
      --strokes meshes/tpu80/strokes-circle.csv \\
      --out out/tpu80/tip.csv --save-state out/tpu80/end.state

Exit codes: 0 done, 1 failed or interrupted, 2 bad input (nothing is written under the final name).";

/// Simulate a robot that follows recorded strokes
///
/// Every sample of the recording is one quasi-static step: the shape in which body, tendons and loads are in
/// balance under the commanded strokes, found from the shape before.
#[derive(Debug, clap::Args)]
#[command(after_help = HELP)]
pub struct Arguments {
    /// Recording with the strokes to follow, .parquet or .csv
    #[arg(long, value_name = "REC")]
    strokes: PathBuf,
    /// Checkpoint by hysteron fit-residual: its network drives the virtual tendons, from the strokes and the twin's tip
    #[arg(long, value_name = "CKPT")]
    residual: Option<PathBuf>,
    #[command(flatten)]
    options: Options,
}

/// Carries out the verb.
pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    carry_out(Task::Simulate, &arguments.strokes, &arguments.options, arguments.residual.as_deref())
}
