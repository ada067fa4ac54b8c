//! Options that every verb which makes a run has.

use std::num::NonZeroUsize;
use std::path::PathBuf;

use crate::shared::body::RobotBodyOptions;

/// Scene and outputs, the same for every verb that makes a run.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct RunOptions {
    /// Scene file of the robot (scene.toml)
    pub scene: PathBuf,
    /// The body that moves it.
    #[cfg_attr(feature = "clap", command(flatten))]
    pub body: RobotBodyOptions,
    /// With a chain: make every N-th step by the finite elements too, and say how far the chain is off
    #[cfg_attr(feature = "clap", arg(long, value_name = "N"))]
    pub exact_every: Option<NonZeroUsize>,
    /// Recording to write, .parquet or .csv
    #[cfg_attr(feature = "clap", arg(long, value_name = "REC"))]
    pub out: PathBuf,
    /// Folder for figures, report.html and metrics.json
    #[cfg_attr(feature = "clap", arg(long, value_name = "DIR"))]
    pub figures: Option<PathBuf>,
    /// Write each figure as .png too
    #[cfg_attr(feature = "clap", arg(long, requires = "figures"))]
    pub png: bool,
    /// Folder for a ParaView series (open robot.pvd): body and tendons
    #[cfg_attr(feature = "clap", arg(long, value_name = "DIR"))]
    pub vtu: Option<PathBuf>,
    /// Every how many samples the series has a picture [default: 200 pictures in all]
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", requires = "vtu"))]
    pub vtu_every: Option<NonZeroUsize>,
    /// Start from this state of the same scene instead of from rest
    #[cfg_attr(feature = "clap", arg(long, value_name = "STATE", conflicts_with = "resume"))]
    pub from: Option<PathBuf>,
    /// Resume the run of this OUT that failed or was interrupted
    #[cfg_attr(feature = "clap", arg(long))]
    pub resume: bool,
    /// Save the last state here, for --from
    #[cfg_attr(feature = "clap", arg(long, value_name = "STATE"))]
    pub save_state: Option<PathBuf>,
}
