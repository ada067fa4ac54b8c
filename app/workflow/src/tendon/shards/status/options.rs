//! Options of `hysteron shards status`.

/// Show how far a planned set is
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    /// Place of the set, as given to hysteron shards plan
    #[cfg_attr(feature = "clap", arg(value_name = "URL"))]
    pub url: String,
}
