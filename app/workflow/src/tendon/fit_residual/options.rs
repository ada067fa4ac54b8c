//! Options of `fit-residual`.

use std::path::PathBuf;

use crate::shared::paper_design::{DesignName, PaperDesign};

/// More networks than any mean gains from.
pub const MAX_MEMBERS: usize = 32;

/// Train the residual network on identified recordings (CoReAct)
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    /// Folders written by hysteron identify, or recordings in them
    #[cfg_attr(feature = "clap", arg(required = true, value_name = "DIR"))]
    pub recordings: Vec<PathBuf>,
    /// Checkpoint to write, .safetensors
    #[cfg_attr(feature = "clap", arg(long, value_name = "CKPT"))]
    pub out: PathBuf,
    /// Which network
    #[cfg_attr(feature = "clap", arg(long, value_enum, default_value_t = DesignName::Recurrent))]
    pub design: DesignName,
    /// Recordings to choose by, by name, from which nothing is learned [default: every recording is left out in one of as many
    /// folds as there are networks, and at least two; the networks then learn from all, for as many epochs as the folds took; paper:
    /// a sixth of every kind of motion and at least one of each that has two, drawn by the seed; a kind is the family of the
    /// plan, or is found from the strokes]
    #[cfg_attr(feature = "clap", arg(long, value_name = "NAME,...", value_delimiter = ','))]
    pub held_out: Vec<String>,
    /// Epochs at most [default: 100; paper: 30]
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", value_parser = crate::shared::number::count::<{ hysteron_learn::MAX_EPOCHS }>))]
    pub epochs: Option<usize>,
    /// Hidden units of a layer [default: 64; paper: 128]
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", value_parser = crate::shared::number::count::<{ hysteron_learn::MAX_HIDDEN }>))]
    pub hidden: Option<usize>,
    /// Networks whose mean is taken; the paper's design has one
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value_t = 3, value_parser = crate::shared::number::count::<MAX_MEMBERS>))]
    pub members: usize,
    /// Inputs of the network are the twin's tip of the sample before (eq. 11) and the strokes, not the strokes alone
    #[cfg_attr(feature = "clap", arg(long))]
    pub feedback: bool,
    /// Folder for report.html and metrics.json [default: OUT without its ending]
    #[cfg_attr(feature = "clap", arg(long, value_name = "DIR"))]
    pub figures: Option<PathBuf>,
    /// Numbers of the published network.
    #[cfg_attr(feature = "clap", command(flatten))]
    pub paper: PaperDesign,
    /// Seed of weights, order and held-out recordings
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value_t = 1))]
    pub seed: u64,
}
