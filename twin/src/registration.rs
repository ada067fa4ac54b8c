//! From the frame of the scene to that in which tips are recorded.

use hysteron_base::TrackerFrame;
use nalgebra::{Matrix3, Rotation3, Vector3};

/// From the frame of the scene to that of the tracker, x ↦ R x + shift.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Registration {
    /// R.
    pub turn: Matrix3<f64>,
    /// Where the scene's origin is recorded [m].
    pub shift: Vector3<f64>,
}

impl Registration {
    /// Of the frame that a scene names.
    pub fn new(frame: &TrackerFrame) -> Self {
        let turn = Rotation3::from_scaled_axis(Vector3::from(frame.turn)).into_inner();
        Self { turn, shift: frame.shift.into() }
    }

    /// Where a point of the scene is recorded [m].
    pub fn point(&self, x: [f64; 3]) -> [f64; 3] {
        (self.turn * Vector3::from(x) + self.shift).into()
    }
}
