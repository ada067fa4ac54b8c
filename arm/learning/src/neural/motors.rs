//! Parameters of the motors of a simulated arm.

use hysteron_base::BadInput;
use serde::{Deserialize, Serialize};

/// Rotor and gears of a motor of the OpenManipulator-X, at the output [kg m²].
const USUAL_ARMATURE: f64 = 0.02;

/// Simulated motors of the joints, where they are not of the size of the release's arm.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Motors {
    /// Rotor and gears, at the output [kg m²]; otherwise 0.1 as published, 0.02 with a servo in the loop.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub armature: Option<f64>,
    /// Damping without a servo in the loop, whose own is identified [N m s/rad]; otherwise 1 as published.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub damping: Option<f64>,
    /// Largest torque [N m]; otherwise 5 as published.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub torque_limit: Option<f64>,
    /// Whether the friction of a servo in the loop grows with the torque through its gear, by a share that is identified with it.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub load_friction: bool,
}

impl Motors {
    /// Rotor and gears of the motors of a servo in the loop, at the output [kg m²].
    pub(super) fn servo_armature(&self) -> f64 {
        self.armature.unwrap_or(USUAL_ARMATURE)
    }

    /// Rotor and gears of the motors of a servo over those of the usual ones [-].
    pub(super) fn size(&self) -> f64 {
        self.servo_armature() / USUAL_ARMATURE
    }

    /// Whether all are as published.
    pub(super) fn are_published(&self) -> bool {
        *self == Self::default()
    }

    /// # Errors
    /// `BadInput` naming what no motor of an arm has.
    pub fn check(&self) -> Result<(), BadInput> {
        let all = [
            ("armature", self.armature, 1e-8..=100.0, "0.00000001 to 100 kg m²"),
            ("damping", self.damping, 0.0..=1000.0, "0 to 1000 N m s/rad"),
            ("torque limit", self.torque_limit, 1e-6..=10_000.0, "0.000001 to 10 000 N m"),
        ];
        for (name, value, range, expected) in all {
            if let Some(value) = value.filter(|value| !range.contains(value)) {
                return Err(BadInput::new(name, expected, value.to_string()));
            }
        }
        Ok(())
    }
}
