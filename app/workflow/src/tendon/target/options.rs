//! Options of `hysteron target`.

use std::path::PathBuf;

/// Sample a path for the tip, and check that a robot reaches it
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    /// Target: FAMILY:SIZE_MM, or a file (.toml, .svg, .csv, .parquet)
    #[cfg_attr(feature = "clap", arg(value_name = "PATH"))]
    pub target: String,
    /// Recording to write, .parquet or .csv
    #[cfg_attr(feature = "clap", arg(long, value_name = "REC"))]
    pub out: PathBuf,
    /// Scene of a robot whose twin must reach it
    #[cfg_attr(feature = "clap", arg(long, value_name = "SCENE"))]
    pub scene: Option<PathBuf>,
    /// Distance that counts as reached
    #[cfg_attr(feature = "clap", arg(long, value_name = "MM", default_value_t = 0.1, requires = "scene", value_parser = crate::shared::number::length_mm))]
    pub tolerance_mm: f64,
    /// Folder for the figure, report.html and metrics.json
    #[cfg_attr(feature = "clap", arg(long, value_name = "DIR"))]
    pub figures: Option<PathBuf>,
    /// Write the figure as .png too
    #[cfg_attr(feature = "clap", arg(long, requires = "figures"))]
    pub png: bool,
}
