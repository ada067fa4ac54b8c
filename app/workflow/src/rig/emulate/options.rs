//! Options of `rig emulate`.

use std::path::PathBuf;

/// Emulate servos and tracker of a rig on their ports
///
/// Needs nothing; makes a serial port and a TCP port that behave like the real servos and the real tracker, in real
/// time, and writes the rig file to go with them.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    /// Amount of friction, backlash and noise of the virtual rig
    #[cfg_attr(feature = "clap", arg(long, value_enum, default_value_t = Preset::Typical, conflicts_with = "robot"))]
    pub preset: Preset,
    /// Virtual robot to emulate, instead of a preset
    #[cfg_attr(feature = "clap", arg(long, value_name = "FILE"))]
    pub robot: Option<PathBuf>,
    /// Seed of noise and of drawn faults
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value_t = 1))]
    pub seed: u64,
    /// Folder for the port, the rig file and the logs
    #[cfg_attr(feature = "clap", arg(long, value_name = "DIR", default_value = "out/rig"))]
    pub dir: PathBuf,
    /// Baud of the servos
    #[cfg_attr(feature = "clap", arg(long, value_name = "BAUD", default_value_t = 1_000_000))]
    pub baud: u32,
    /// Delay before a servo answers
    #[cfg_attr(
        feature = "clap",
        arg(long, value_name = "US", default_value_t = 500.0, allow_negative_numbers = true)
    )]
    pub return_delay_us: f64,
    /// Faults to inject (.toml)
    #[cfg_attr(feature = "clap", arg(long, value_name = "FILE"))]
    pub faults: Option<PathBuf>,
    /// Draw that many faults, spread over the time of --for-s
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value_t = 0, requires = "for_s"))]
    pub draw_faults: u32,
    /// Sleep instead of polling: answers come some 0.1 ms late, and the processor stays free
    #[cfg_attr(feature = "clap", arg(long))]
    pub relaxed: bool,
    /// TCP port on which the tracker serves its poses, by OpenIGTLink; 0 for any that is free
    #[cfg_attr(feature = "clap", arg(long, value_name = "PORT", default_value_t = 18944))]
    pub port_tracker: u16,
    /// End after that many seconds [default: at Ctrl-C]
    #[cfg_attr(feature = "clap", arg(long, value_name = "SECONDS", allow_negative_numbers = true))]
    pub for_s: Option<f64>,
}

/// How far the virtual rig is from an ideal one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum Preset {
    /// Little of each
    Mild,
    /// As the rigs on which the presets are based
    Typical,
    /// More than most
    Harsh,
    /// A robot drawn from the wide population
    Wide,
}

impl Preset {
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Mild => "mild",
            Self::Typical => "typical",
            Self::Harsh => "harsh",
            Self::Wide => "wide",
        }
    }
}
