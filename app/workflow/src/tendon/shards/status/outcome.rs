//! The outcome of `shards status`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::Context;

/// The outcome of `shards status`.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Outcome {
    /// Place of the set.
    pub url: String,
    /// Name of the plan.
    pub plan: String,
    /// Shards of the set.
    pub shards: usize,
    /// Shards that are done.
    pub done: usize,
    /// Shards that are missing.
    pub missing: usize,
    /// The missing shards in words, the first few.
    pub missing_shards: String,
    /// Shards among the missing ones whose rows are stored without their sketch: their worker ended in between.
    pub unfinished: usize,
    /// Size of the rows [byte].
    pub bytes: u64,
    /// Shards done in an hour, from the first to the last, by the clock of the store; absent with fewer than two.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shards_per_hour: Option<f64>,
    /// Time for the missing shards at that rate [h].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hours_left: Option<f64>,
}

impl crate::shared::outcome::Outcome for Outcome {}

impl Outcome {
    /// Prints it.
    pub(super) fn print(&self, context: &Context) {
        let Self { plan, done, shards, missing, .. } = self;
        let part = 100.0 * *done as f64 / *shards as f64;
        context.print(format_args!(
            "plan {plan}: {done} of {shards} shards are done ({part:.1} %), {:.3} GB",
            1e-9 * self.bytes as f64
        ));
        if *missing == 0 {
            context.print(format_args!("complete; its card: hysteron shards merge {} --out DIR", self.url));
            return;
        }
        context.print(format_args!("{missing} are missing: {}", self.missing_shards));
        if self.unfinished > 0 {
            context.print(format_args!(
                "{} of them have rows and no sketch yet: a worker is about to write it, or was ended before",
                self.unfinished
            ));
        }
        if let (Some(rate), Some(left)) = (self.shards_per_hour, self.hours_left) {
            context.print(format_args!("{rate:.1} shards an hour so far; {left:.2} h left at this rate"));
        }
    }
}
