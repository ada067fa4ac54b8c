//! Where the tip is, by the tracker.

/// A measured pose.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    /// When it was measured [s], on the clock that the function giving it names.
    pub time: f64,
    /// Position of the sensor [m].
    pub position: [f64; 3],
    /// Orientation of the sensor, a unit quaternion w, x, y, z [-].
    pub orientation: [f64; 4],
    /// Whether it can be trusted.
    pub quality: Quality,
}

/// Whether a pose can be trusted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quality {
    /// Nothing speaks against it.
    Good,
    /// The tracker itself marks it as invalid.
    Flagged,
    /// The same values as before, more often than the sensor's noise allows, or while the tip must have moved.
    Frozen,
    /// Further from the pose before than the tip can move.
    Jump,
}
