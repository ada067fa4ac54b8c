//! How a map describes further files, and columns with a clock of their own.

use serde::Deserialize;

/// How further files come to the rows of the first.
#[derive(Debug, Clone, PartialEq, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Join {
    /// The column whose equal values join rows; by time without one.
    pub by: Option<String>,
    /// The further file's column of times; called as in the first where it is not named.
    pub time: Option<String>,
    /// Added to its times [s].
    #[serde(default)]
    pub offset_s: f64,
    /// True where a value holds until the next; else values lie on lines between samples.
    #[serde(default)]
    pub hold: bool,
}

/// Columns of a file that have a clock of their own.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ClockedColumns {
    /// The column of their times, in the unit of the file's.
    pub time: String,
    pub columns: Vec<String>,
    /// Added to the times [s].
    #[serde(default)]
    pub offset_s: f64,
    /// True where a value holds until the next.
    #[serde(default)]
    pub hold: bool,
}
