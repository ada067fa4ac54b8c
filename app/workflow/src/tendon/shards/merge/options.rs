//! Options of `hysteron shards merge`.

use std::path::PathBuf;

/// Write the card of a set made in shards
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    /// Place of the set, as given to hysteron shards plan
    #[cfg_attr(feature = "clap", arg(value_name = "URL"))]
    pub url: String,
    /// Folder of the card
    #[cfg_attr(feature = "clap", arg(long, value_name = "DIR"))]
    pub out: PathBuf,
    /// Write the card of the shards that are there, even if some are missing
    #[cfg_attr(feature = "clap", arg(long))]
    pub partial: bool,
    /// Write the figure as .png too
    #[cfg_attr(feature = "clap", arg(long))]
    pub png: bool,
}
