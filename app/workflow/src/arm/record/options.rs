//! Options of `arm record`.

use std::path::PathBuf;

/// Record a follower that follows the leader in your hand
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    /// File of both arms (.toml)
    #[cfg_attr(feature = "clap", arg(long, value_name = "FILE"))]
    pub arms: PathBuf,
    /// Recording to write, .parquet or .csv
    #[cfg_attr(feature = "clap", arg(long, value_name = "REC"))]
    pub out: PathBuf,
    /// End after that many seconds [default: at Ctrl-C]
    #[cfg_attr(feature = "clap", arg(long, value_name = "SECONDS", allow_negative_numbers = true))]
    pub seconds: Option<f64>,
    /// Payload of the follower; the recording names it
    #[cfg_attr(
        feature = "clap",
        arg(long, value_name = "G", default_value_t = 0.0, allow_negative_numbers = true)
    )]
    pub payload_g: f64,
    /// A motor of the follower is degraded; the recording is marked
    #[cfg_attr(feature = "clap", arg(long))]
    pub degraded: bool,
}
