//! Choices of a tendon's solver for each of its guides; see `policies.rs`.

/// Choices of one guide.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct GuideChoices {
    /// Of the maximum: it slides towards the pulley.
    pub is_pulling: bool,
    /// Of the maximum: the segment before it is taut.
    pub is_left_taut: bool,
    /// Of the minimum: it sticks, unless it is pulling.
    pub is_stuck: bool,
    /// Of the minimum: the segment after it is taut.
    pub is_right_taut: bool,
}
