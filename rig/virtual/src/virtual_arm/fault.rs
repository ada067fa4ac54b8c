//! Faults of a joint.

/// Something wrong with one joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum JointFault {
    /// Dry friction of the gear grows.
    Friction {
        /// Number of the joint, from 0.
        joint: usize,
        /// Factor on dry friction [-].
        factor: f64,
    },
    /// A rubber band pulls back beyond an angle.
    Band {
        /// Number of the joint, from 0.
        joint: usize,
        /// [N m/rad].
        stiffness: f64,
        /// Angle from which it is taut [rad].
        from: f64,
    },
    /// A tooth is gone: around an angle the backlash is larger.
    LostTooth {
        /// Number of the joint, from 0.
        joint: usize,
        /// Where it was [rad].
        at: f64,
        /// Half the way over which it is missed [rad].
        width: f64,
        /// Backlash where it was [rad].
        backlash: f64,
    },
}

impl JointFault {
    /// Number of the joint, from 0.
    pub fn joint(&self) -> usize {
        match *self {
            Self::Friction { joint, .. } | Self::Band { joint, .. } | Self::LostTooth { joint, .. } => joint,
        }
    }

    /// Description of the fault, with its numbers.
    pub fn describe(&self) -> String {
        let joint = self.joint() + 1;
        match *self {
            Self::Friction { factor, .. } => format!("joint {joint}: dry friction x {factor:.3}"),
            Self::Band { stiffness, from, .. } => {
                format!(
                    "joint {joint}: rubber band of {stiffness:.3} N m/rad from {:.1} deg",
                    from.to_degrees()
                )
            }
            Self::LostTooth { at, backlash, .. } => {
                let [at, backlash] = [at, backlash].map(f64::to_degrees);
                format!("joint {joint}: backlash {backlash:.2} deg around {at:.1} deg")
            }
        }
    }

    /// Factor on the dry friction of `joint`.
    pub(super) fn friction_factor(&self, joint: usize) -> f64 {
        match *self {
            Self::Friction { joint: its, factor } if its == joint => factor,
            _ => 1.0,
        }
    }

    /// Torque on the link of `joint` at `angle` [N m].
    pub(super) fn torque(&self, joint: usize, angle: f64) -> f64 {
        match *self {
            Self::Band { joint: its, stiffness, from } if its == joint => {
                -stiffness * (angle - from).max(0.0)
            }
            _ => 0.0,
        }
    }

    /// Backlash that comes on top of `backlash` in `joint` at `angle` [rad].
    pub(super) fn more_backlash(&self, joint: usize, angle: f64, of: f64) -> f64 {
        match *self {
            Self::LostTooth { joint: its, at, width, backlash }
                if its == joint && (angle - at).abs() < width =>
            {
                let near = (std::f64::consts::FRAC_PI_2 * (angle - at) / width).cos();
                (backlash - of).max(0.0) * near * near
            }
            _ => 0.0,
        }
    }
}
