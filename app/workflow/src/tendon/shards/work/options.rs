//! Options of `hysteron shards work`.

use crate::tendon::generate::Shard;

/// Make shards of a planned set until none is missing
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    /// Place of the set, as given to hysteron shards plan
    #[cfg_attr(feature = "clap", arg(value_name = "URL"))]
    pub url: String,
    /// Only every N-th shard, from the I-th on [default: any that is missing]
    #[cfg_attr(feature = "clap", arg(long, value_name = "I/N"))]
    pub worker: Option<Shard>,
}
