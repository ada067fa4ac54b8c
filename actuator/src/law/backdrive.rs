//! Which motor torques hold a load, lift it, or let it turn the gear: the drive and backdrive diagram.
//!
//! # Reference
//! Duclusaud et al. (2024), figure 3.

use super::{JointFriction, Sliding};

/// Motor torques at which a joint at rest begins to move under a load that pulls it back with `load` ≥ 0 [N m].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HoldingRange {
    /// Above this one the motor lifts the load; `None` where friction grows faster than the torque, and no torque does [N m].
    pub drive: Option<f64>,
    /// Below this one the load turns the motor back; negative where the motor has to help it [N m].
    pub backdrive: f64,
}

/// Relative accuracy of the torques [-].
const ACCURACY: f64 = 1e-10;
/// Torque, relative to load and friction, beyond which no motor is looked for [-].
const FARTHEST: f64 = 1e3;

/// The range for `law` with the parameters `p`.
pub fn holding_range<L: JointFriction>(law: &L, p: &[f64], load: f64) -> HoldingRange {
    let dry = |velocity: f64, motor_torque: f64| {
        law.budget(p, &Sliding { velocity, motor_torque, load_torque: -load }).dry
    };
    // Standstill, approached from either direction.
    let slowest = f64::MIN_POSITIVE;
    let size = load + dry(slowest, load) + f64::MIN_POSITIVE;
    let surplus = |motor: f64| motor - load - dry(slowest, motor);
    let deficit = |motor: f64| load - motor - dry(-slowest, motor);
    let drive = root(&surplus, [load, load + size], FARTHEST * size);
    let backdrive = root(&|x: f64| deficit(load - x), [0.0, size], FARTHEST * size);
    HoldingRange { drive, backdrive: load - backdrive.unwrap_or(FARTHEST * size) }
}

/// Where a function that begins at or below zero becomes positive, by bisection.
fn root(f: &dyn Fn(f64) -> f64, [mut low, mut high]: [f64; 2], farthest: f64) -> Option<f64> {
    let first = low;
    while f(high) <= 0.0 {
        if high - first > farthest {
            return None;
        }
        (low, high) = (high, first + 2.0 * (high - first));
    }
    while high - low > ACCURACY * high.abs().max(low.abs()) {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            break;
        }
        if f(middle) > 0.0 { high = middle } else { low = middle }
    }
    Some(0.5 * (low + high))
}

#[cfg(test)]
#[allow(clippy::unwrap_used)] // a test may stop where it stands
mod tests {
    use super::*;
    use crate::law::{CoulombViscous, LoadDependent};

    #[test]
    fn coulomb_friction_holds_as_much_to_both_sides() {
        let range = holding_range(&CoulombViscous, &[0.3, 0.1], 2.0);
        assert!(
            (range.drive.unwrap() - 2.3).abs() < 1e-9 && (range.backdrive - 1.7).abs() < 1e-9,
            "{range:?}"
        );
    }

    #[test]
    fn a_gear_that_rubs_with_its_load_has_the_closed_range() {
        // K_c + K_l (τ_m + L) = ± (τ_m - L) with K_c = 0.1, K_l = 0.25.
        let range = holding_range(&LoadDependent::M3, &[0.1, 0.05, 0.25], 2.0);
        assert!((range.drive.unwrap() - (2.0 * 1.25 + 0.1) / 0.75).abs() < 1e-8, "{range:?}");
        assert!((range.backdrive - (2.0 * 0.75 - 0.1) / 1.25).abs() < 1e-8, "{range:?}");
    }

    #[test]
    fn a_gear_that_locks_itself_cannot_be_driven() {
        assert_eq!(holding_range(&LoadDependent::M3, &[0.1, 0.05, 1.2], 2.0).drive, None);
    }
}
