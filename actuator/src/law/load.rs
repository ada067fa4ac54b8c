//! Friction that grows with what a gear transmits.
//!
//! # Reference
//! Duclusaud, Passault, Padois, Ly (2024), Extended friction models for the physics simulation of servo actuators,
//! models M1 to M6, with the parameters' names as in their program bam.

use super::{Budget, JointFriction, LawParameter, Sliding, damping, number, torque};
use crate::number::Real;

/// bam's models, each an extension of the ones before.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LoadDependent {
    /// Coulomb and viscous.
    M1,
    /// M1 with Stribeck's excess.
    M2,
    /// M1 with a part of the torque through the gear.
    M3,
    /// M3 with Stribeck's excess, of the load's part too.
    M4,
    /// M4 with different parts of the motor's torque and the load's.
    M5,
    /// M5 with squares of both torques.
    M6,
}

const ALL: [LoadDependent; 6] = [
    LoadDependent::M1,
    LoadDependent::M2,
    LoadDependent::M3,
    LoadDependent::M4,
    LoadDependent::M5,
    LoadDependent::M6,
];

impl LoadDependent {
    /// "m1" to "m6".
    pub fn named(name: &str) -> Option<Self> {
        let number: usize = name.strip_prefix('m')?.parse().ok()?;
        ALL.get(number.checked_sub(1)?).copied()
    }

    /// "m1" to "m6".
    pub fn name(self) -> &'static str {
        ["m1", "m2", "m3", "m4", "m5", "m6"][self as usize]
    }
}

impl JointFriction for LoadDependent {
    fn parameters(&self) -> Vec<LawParameter> {
        let mut all = vec![torque("friction_base"), damping("friction_viscous")];
        let share = |name| number(name, 0.0, 0.6);
        match self {
            Self::M1 => {}
            Self::M2 => all.push(torque("friction_stribeck")),
            Self::M3 => all.push(share("load_friction_base")),
            Self::M4 => {
                all.extend([
                    torque("friction_stribeck"),
                    share("load_friction_base"),
                    share("load_friction_stribeck"),
                ]);
            }
            Self::M5 | Self::M6 => all.extend([
                torque("friction_stribeck"),
                share("load_friction_motor"),
                share("load_friction_external"),
                share("load_friction_motor_stribeck"),
                share("load_friction_external_stribeck"),
            ]),
        }
        if *self == Self::M6 {
            all.extend([
                number("load_friction_motor_quad", 0.0, 0.3),
                number("load_friction_external_quad", 0.0, 0.3),
            ]);
        }
        if !matches!(self, Self::M1 | Self::M3) {
            all.extend([number("dtheta_stribeck", 0.01, 10.0), number("alpha", 0.3, 10.0)]);
        }
        all
    }

    fn budget<T: Real>(&self, p: &[T], at: &Sliding<T>) -> Budget<T> {
        let through = (at.load_torque - at.motor_torque).abs();
        // exp(-|v/v_s|^α), the last two parameters.
        let low_speed = || {
            let [v_s, alpha] = [p[p.len() - 2], p[p.len() - 1]];
            (-(at.velocity.abs() / v_s).powf(alpha)).exp()
        };
        let dry = match self {
            Self::M1 => p[0],
            Self::M2 => p[0] + low_speed() * p[2],
            Self::M3 => p[0] + p[2] * through,
            Self::M4 => p[0] + p[3] * through + low_speed() * (p[2] + p[4] * through),
            Self::M5 | Self::M6 => {
                let gear = |motor: T, load: T| (load * at.load_torque - motor * at.motor_torque).abs();
                let steady = p[0] + gear(p[3], p[4]) + low_speed() * (p[2] + gear(p[5], p[6]));
                match self {
                    Self::M6 => {
                        let squares =
                            p[8] * at.load_torque * at.load_torque + p[7] * at.motor_torque * at.motor_torque;
                        steady + squares
                    }
                    _ => steady,
                }
            }
        };
        Budget { dry, viscous: p[1] }
    }
}
