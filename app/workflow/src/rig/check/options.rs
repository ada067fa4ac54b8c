//! Options of `rig check`.

use std::path::PathBuf;

/// List serial ports; check servos, their registers and the tracker of a rig, or both arms
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    /// Rig file, or file of two arms
    #[cfg_attr(feature = "clap", arg(long, value_name = "RIG"))]
    pub rig: Option<PathBuf>,
    /// Calibration whose registers are expected [default: the file that the rig file names]
    #[cfg_attr(feature = "clap", arg(long, value_name = "FILE", requires = "rig"))]
    pub calibration: Option<PathBuf>,
    /// Restart every servo first: clears hardware errors whose cause is gone
    #[cfg_attr(feature = "clap", arg(long, requires = "rig"))]
    pub reboot: bool,
    /// Switch the torque of every servo off, for example where a lost cable has left it on
    #[cfg_attr(feature = "clap", arg(long, requires = "rig"))]
    pub release: bool,
    /// Write back the registers that differ from what is expected, after asking; switches the torque off first
    #[cfg_attr(feature = "clap", arg(long, requires = "rig"))]
    pub restore: bool,
    /// Write back without asking
    #[cfg_attr(feature = "clap", arg(long, requires = "restore"))]
    pub yes: bool,
}
