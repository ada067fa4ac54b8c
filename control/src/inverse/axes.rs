//! Where a tip is to go: in the plane across a robot, or in space.

use serde::{Deserialize, Serialize};

/// A tip [m]: x, y and z. In the plane z is zero.
pub type TipPosition = [f64; 3];

/// Coordinates that describe a tip.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Axes {
    /// x and y: enough where they determine z, as for a robot that bends as a whole.
    #[default]
    Planar,
    /// x, y and z: for a robot of several segments.
    Spatial,
}

impl Axes {
    /// Their names.
    pub fn names(self) -> &'static [&'static str] {
        match self {
            Self::Planar => &["x", "y"],
            Self::Spatial => &["x", "y", "z"],
        }
    }

    /// How many they are.
    pub fn len(self) -> usize {
        self.names().len()
    }

    /// False: a tip has at least two coordinates.
    pub fn is_empty(self) -> bool {
        false
    }
}
