//! `hysteron shards merge`: the card of a set, from the sketches of its shards.

mod options;
mod outcome;
mod page;
mod run;

pub use options::Options;
pub use outcome::{ChannelStatistics, FamilySamples, Outcome, SkippedExample};
pub use run::run;
