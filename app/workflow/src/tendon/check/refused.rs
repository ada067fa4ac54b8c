//! The error of recordings that cannot be right.

use hysteron_base::BadInput;

use crate::shared::outcome::Printed;

/// Recordings of which something cannot be right; all findings have been printed.
#[derive(Debug)]
pub struct Refused {
    /// The outcome, which `--json` prints all the same.
    pub outcome: Printed,
    /// Findings that cannot be right.
    pub(super) n_errors: usize,
    /// The first of them.
    pub(super) first: BadInput,
}

impl std::fmt::Display for Refused {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} of the findings cannot be right, the first", self.n_errors)
    }
}

impl std::error::Error for Refused {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        Some(&self.first)
    }
}
