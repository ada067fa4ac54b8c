//! Options of `record`.

use std::path::{Path, PathBuf};

use crate::tendon::sense::live::LiveOptions;

/// Run a plan on a rig and record it
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    /// Rig file, or virtual:PRESET
    #[cfg_attr(feature = "clap", arg(long, value_name = "RIG"))]
    pub rig: PathBuf,
    /// Plan file (.toml), or the name of a built-in plan
    #[cfg_attr(feature = "clap", arg(long, value_name = "PLAN", required_unless_present = "strokes"))]
    pub plan: Option<String>,
    /// Strokes to run instead of a plan: recordings with stroke_1_m, .., or folders of them
    #[cfg_attr(feature = "clap", arg(long, value_name = "REC", num_args = 1.., conflicts_with_all = ["plan", "only"]))]
    pub strokes: Vec<PathBuf>,
    /// Folder for the recordings; for a single trajectory also a file, .parquet or .csv
    #[cfg_attr(feature = "clap", arg(long, value_name = "OUT"))]
    pub out: PathBuf,
    /// Only these trajectories of the plan, by name
    #[cfg_attr(feature = "clap", arg(long, value_name = "NAME,...", value_delimiter = ','))]
    pub only: Vec<String>,
    /// Calibration [default: the file that the rig file names; a virtual rig calibrates itself]
    #[cfg_attr(feature = "clap", arg(long, value_name = "FILE"))]
    pub calibration: Option<PathBuf>,
    /// Seed of a virtual rig's noise and of the initial positions of its servos
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value_t = 1))]
    pub seed: u64,
    /// Correct the strokes while they are run, by the tip that the tracker measures: slowly, towards the path that --strokes is for
    /// (hysteron track --feedback writes such strokes)
    #[cfg_attr(feature = "clap", arg(long))]
    pub feedback: bool,
    /// Force on a virtual rig's tip over time: a recording of tip_force_x_n, tip_force_y_n, tip_force_z_n, in the robot's
    /// frame; true tensions and force are then recorded too
    #[cfg_attr(feature = "clap", arg(long, value_name = "REC"))]
    pub tip_force: Option<PathBuf>,
    /// Estimates contacts and tensions while it records.
    #[cfg_attr(feature = "clap", command(flatten))]
    pub live: Option<LiveOptions>,
    /// State of the healthy servos as a baseline: metrics.json of an earlier record or track, or the output of
    /// hysteron identify-servo
    #[cfg_attr(feature = "clap", arg(long, value_name = "FILE"))]
    pub baseline: Option<PathBuf>,
    /// Folder for figures, report.html and metrics.json [default: OUT, where it is a folder]
    #[cfg_attr(feature = "clap", arg(long, value_name = "DIR"))]
    pub figures: Option<PathBuf>,
    /// Write each figure as .png too
    #[cfg_attr(feature = "clap", arg(long))]
    pub png: bool,
}

impl Options {
    /// Strokes of one recording, on a rig, into one file.
    pub fn of_strokes(
        rig: &Path,
        strokes: &Path,
        out: &Path,
        calibration: Option<PathBuf>,
        seed: u64,
    ) -> Self {
        Self {
            rig: rig.to_owned(),
            plan: None,
            strokes: vec![strokes.to_owned()],
            out: out.to_owned(),
            only: Vec::new(),
            calibration,
            seed,
            feedback: false,
            tip_force: None,
            live: None,
            baseline: None,
            figures: None,
            png: false,
        }
    }
}
