//! Options of `hysteron simulate`.

use std::path::PathBuf;

use crate::shared::run::RunOptions;

/// Simulate a robot that follows recorded strokes
///
/// Every sample of the recording is one quasi-static step: the shape in which body, tendons and loads are in
/// balance under the commanded strokes, found from the shape before.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    /// Recording with the strokes to follow, .parquet or .csv
    #[cfg_attr(feature = "clap", arg(long, value_name = "REC"))]
    pub strokes: PathBuf,
    /// Checkpoint by hysteron fit-residual: its network drives the auxiliary tendons, from the strokes and the
    /// twin's tip. Where recordings were left out in its training, how far the robot's tip may be off the twin's is
    /// told, drawn and written too, as tip_band_m
    #[cfg_attr(feature = "clap", arg(long, value_name = "CKPT"))]
    pub residual: Option<PathBuf>,
    /// Scene and outputs.
    #[cfg_attr(feature = "clap", command(flatten))]
    pub run: RunOptions,
}
