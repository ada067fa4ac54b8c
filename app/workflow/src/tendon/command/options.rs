//! Options of `hysteron command`.

use std::path::PathBuf;

/// Find the strokes that bring the tip along a path (EDIC)
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    /// The path, and the method that finds strokes for it.
    #[cfg_attr(feature = "clap", command(flatten))]
    pub way: Way,
    /// Recording to write, .parquet or .csv
    #[cfg_attr(feature = "clap", arg(long, value_name = "REC"))]
    pub out: PathBuf,
    /// Smallest stroke [default: that of the training; with --scene, the opposite of the largest]
    #[cfg_attr(feature = "clap", arg(long, value_name = "MM", allow_negative_numbers = true, conflicts_with = "scene", value_parser = crate::shared::number::position_mm))]
    pub stroke_min_mm: Option<f64>,
    /// Largest stroke [default: that of the training; with --scene 16]
    #[cfg_attr(feature = "clap", arg(long, value_name = "MM", allow_negative_numbers = true, value_parser = crate::shared::number::position_mm))]
    pub stroke_max_mm: Option<f64>,
    /// Fastest change of a stroke [default: that of the training; with --scene 12]
    #[cfg_attr(feature = "clap", arg(long, value_name = "MM/S", allow_negative_numbers = true, value_parser = crate::shared::number::speed_mm_s))]
    pub stroke_rate_max_mm_s: Option<f64>,
    /// Folder for figures and report.html
    #[cfg_attr(feature = "clap", arg(long, value_name = "DIR"))]
    pub figures: Option<PathBuf>,
}

/// The path and the method that finds strokes for it.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Way {
    /// Checkpoint by hysteron train, whose network finds the strokes, or the twin that it names as better; with --scene, by hysteron fit-residual
    #[cfg_attr(feature = "clap", arg(value_name = "CKPT", required_unless_present = "scene"))]
    pub checkpoint: Option<PathBuf>,
    /// Path that the tip shall follow
    #[cfg_attr(feature = "clap", arg(long, value_name = "PATH"))]
    pub target: String,
    /// Steer the twin of this scene along the path
    #[cfg_attr(feature = "clap", arg(long, value_name = "SCENE"))]
    pub scene: Option<PathBuf>,
    /// Ignore the parameters of the scene that are fitted to a robot: zeros and compliance of the tendons, friction, backlash
    #[cfg_attr(feature = "clap", arg(long, requires = "scene", conflicts_with = "checkpoint"))]
    pub nominal: bool,
    /// Find the strokes by the network of the checkpoint, even where the checkpoint names a twin that leads the tip closer
    #[cfg_attr(feature = "clap", arg(long, conflicts_with = "scene"))]
    pub network: bool,
}
