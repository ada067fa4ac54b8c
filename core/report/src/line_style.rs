//! How lines of a figure are drawn.

/// Lines of the curves of a figure.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LineStyle {
    /// All solid.
    Solid,
    /// A pattern of dashes for each colour, as a second cue.
    ByColor,
}
