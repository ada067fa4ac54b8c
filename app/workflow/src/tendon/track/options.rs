//! Options of `hysteron track`.

use std::path::PathBuf;

use crate::tendon::command::Way;

/// More repeats than fit in a day.
#[cfg(feature = "clap")]
const MAX_REPEATS: usize = 100;

/// Follow a path open loop on a rig, and measure it
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    /// The path, and the method that finds strokes for it.
    #[cfg_attr(feature = "clap", command(flatten))]
    pub way: Way,
    /// Rig file, or virtual:PRESET
    #[cfg_attr(feature = "clap", arg(long, value_name = "RIG"))]
    pub rig: PathBuf,
    /// Folder to write to
    #[cfg_attr(feature = "clap", arg(long, value_name = "DIR"))]
    pub out: PathBuf,
    /// How often the strokes are run
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value_t = 1, value_parser = crate::shared::number::count::<MAX_REPEATS>))]
    pub repeats: usize,
    /// Learn from each repeat how to lead the tip in the next (iterative learning control); the repeats are scored one by one
    #[cfg_attr(feature = "clap", arg(long))]
    pub learn: bool,
    /// Correct the strokes while they are run, by the tip that the tracker measures: slowly, so that errors of less than about half a hertz
    /// go; what was commanded is recorded
    #[cfg_attr(feature = "clap", arg(long))]
    pub feedback: bool,
    /// Calibration [default: the file that the rig file names; a virtual rig calibrates itself]
    #[cfg_attr(feature = "clap", arg(long, value_name = "FILE"))]
    pub calibration: Option<PathBuf>,
    /// Seed of a virtual rig's noise; every repeat has the next one
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value_t = 1))]
    pub seed: u64,
    /// State of the healthy servos as a baseline: metrics.json of an earlier record or track, or the output of
    /// hysteron identify-servo
    #[cfg_attr(feature = "clap", arg(long, value_name = "FILE"))]
    pub baseline: Option<PathBuf>,
    /// Write each figure as .png too
    #[cfg_attr(feature = "clap", arg(long))]
    pub png: bool,
}
