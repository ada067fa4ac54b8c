//! Options of `hysteron evaluate`.

use std::path::{Path, PathBuf};

/// Measure how closely recorded tips followed a target path
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    /// Target: a file, or FAMILY:SIZE_MM
    #[cfg_attr(feature = "clap", arg(long, value_name = "PATH"))]
    pub target: String,
    /// Recordings, .parquet or .csv, paths without times (.csv with x_mm and y_mm), or folders of them: repeats of one experiment, or of each NAME
    #[cfg_attr(feature = "clap", arg(required = true, value_name = "[NAME=]REC"))]
    pub results: Vec<String>,
    /// Folder for report.html, metrics.json and figures
    #[cfg_attr(feature = "clap", arg(long, value_name = "DIR"))]
    pub out: Option<PathBuf>,
    /// Write each figure as .png too
    #[cfg_attr(feature = "clap", arg(long, requires = "out"))]
    pub png: bool,
    /// All samples belong to the curve, at any time: scores of its geometry alone, without lag and RMSE at the same times. A
    /// path without times (.csv with x_mm and y_mm) has no other scores
    #[cfg_attr(feature = "clap", arg(long, visible_alias = "geometry"))]
    pub whole: bool,
    /// Measure the tip from where it rested at the beginning
    #[cfg_attr(feature = "clap", arg(long, conflicts_with = "whole"))]
    pub relative_to_rest: bool,
}

impl Options {
    /// Recordings of one target, with a report in `out`.
    pub fn of(target: &str, recordings: Vec<PathBuf>, out: &Path) -> Self {
        let (target, out) = (target.to_owned(), Some(out.to_owned()));
        let results = recordings.iter().map(|path| path.display().to_string()).collect();
        Self { target, results, out, png: false, whole: false, relative_to_rest: false }
    }
}
