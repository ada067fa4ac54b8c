//! Options of `rig calibrate`.

use std::path::PathBuf;

/// Find zero, slack and pretension of every tendon, and the tracker's frame
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    /// Rig file, or virtual:PRESET
    #[cfg_attr(feature = "clap", arg(long, value_name = "RIG"))]
    pub rig: PathBuf,
    /// Calibration to write [default: the file that the rig file names]
    #[cfg_attr(feature = "clap", arg(long, value_name = "FILE"))]
    pub out: Option<PathBuf>,
    /// Store the present registers of the servos in the calibration, also where they differ from the one before or from the
    /// factory
    #[cfg_attr(feature = "clap", arg(long))]
    pub keep_registers: bool,
    /// Seed of a virtual rig
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value_t = 1))]
    pub seed: u64,
}
