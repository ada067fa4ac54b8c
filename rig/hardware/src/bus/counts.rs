//! Counts of the bus traffic and its errors: every retry is counted.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Counts since the bus was opened.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct BusCounts {
    /// Instructions sent, those sent again included.
    pub instructions: u64,
    /// Answers that came whole.
    pub answers: u64,
    /// Answers that did not come in time.
    pub timeouts: u64,
    /// Answers that were damaged, or from another servo.
    pub corrupt: u64,
    /// Instructions that a servo refused.
    pub refused: u64,
    /// Instructions sent again.
    pub retries: u64,
    /// Reads that failed although asked again.
    pub lost: u64,
    /// Times that the port was opened again.
    pub reopened: u64,
}

impl std::ops::AddAssign for BusCounts {
    fn add_assign(&mut self, more: Self) {
        self.instructions += more.instructions;
        self.answers += more.answers;
        self.timeouts += more.timeouts;
        self.corrupt += more.corrupt;
        self.refused += more.refused;
        self.retries += more.retries;
        self.lost += more.lost;
        self.reopened += more.reopened;
    }
}
