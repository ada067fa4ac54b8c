//! The outcome of `shards work`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::Context;

/// The outcome of `shards work`.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Outcome {
    /// Place of the set.
    pub url: String,
    /// Shards that this worker has made.
    pub made: usize,
    /// Shards that this worker has made and another one has stored first.
    pub made_twice: usize,
    /// Shards that were there already.
    pub already_there: usize,
    /// Samples that this worker has simulated.
    pub samples: u64,
    /// Time that it took [s].
    pub seconds: f64,
}

impl crate::shared::outcome::Outcome for Outcome {}

impl Outcome {
    /// Prints what was done.
    pub(super) fn print(&self, context: &Context) {
        let rate = self.samples as f64 / self.seconds.max(f64::MIN_POSITIVE);
        context.print(format_args!(
            "{} shards made, {} already there, {} made twice; {} samples in {:.1} s, {rate:.0} a second",
            self.made, self.already_there, self.made_twice, self.samples, self.seconds
        ));
    }
}
