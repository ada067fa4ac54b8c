//! Options of `hysteron reach`.

use std::path::PathBuf;

use crate::shared::run::RunOptions;

/// Find the strokes that bring the tip to recorded goals
///
/// The inverse of `simulate`: for every sample, the strokes whose equilibrium has the tip at the goal, found from the
/// shape before.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    /// Recording with the tip positions to reach, .parquet or .csv
    #[cfg_attr(feature = "clap", arg(long, value_name = "REC"))]
    pub goals: PathBuf,
    /// Distance that counts as reached
    #[cfg_attr(feature = "clap", arg(long, value_name = "MM", default_value_t = 0.01, value_parser = crate::shared::number::length_mm))]
    pub tolerance_mm: f64,
    /// Scene and outputs.
    #[cfg_attr(feature = "clap", command(flatten))]
    pub run: RunOptions,
}
