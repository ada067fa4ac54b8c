//! Options of `arm emulate`.

use std::path::PathBuf;

/// Emulate a follower and the leader that a hand moves, on two ports
///
/// Needs nothing; makes two serial ports that behave like the servos of both arms, in real time, and writes the file of both
/// arms.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    /// Folder for the ports, the file of both arms and the log of torques
    #[cfg_attr(feature = "clap", arg(long, value_name = "DIR", default_value = "out/arms"))]
    pub dir: PathBuf,
    /// Virtual arm: a file of TOML or a built-in name
    #[cfg_attr(feature = "clap", arg(long, value_name = "ARM", default_value = "open-manipulator-x"))]
    pub arm: String,
    /// Seed of the individual arm, the hand's motion and all noise
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value_t = 0))]
    pub seed: u64,
    /// Motion of the hand and the obstacles in its way: a trajectory of `hysteron arm generate`
    #[cfg_attr(
        feature = "clap",
        arg(long, value_name = "NAME", default_value = "force_unlabeled/backward_forward/test/001")
    )]
    pub trajectory: String,
    /// Time until the hand begins to move
    #[cfg_attr(
        feature = "clap",
        arg(long, value_name = "SECONDS", default_value_t = 10.0, allow_negative_numbers = true)
    )]
    pub begins_s: f64,
    /// Faults of the follower to inject (.toml)
    #[cfg_attr(feature = "clap", arg(long, value_name = "FILE"))]
    pub faults: Option<PathBuf>,
    /// Sleep instead of polling: answers come some 0.1 ms late, and the processor stays free
    #[cfg_attr(feature = "clap", arg(long))]
    pub relaxed: bool,
    /// End after that many seconds [default: at Ctrl-C]
    #[cfg_attr(feature = "clap", arg(long, value_name = "SECONDS", allow_negative_numbers = true))]
    pub for_s: Option<f64>,
}
