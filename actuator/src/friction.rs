//! Dry friction: Coulomb, Stribeck and viscous at a joint, capstan at a guide.
//!
//! Sticking is not approximated by a steep slope: a joint's new speed is found implicitly ([`crate::Drive`]), and it is exactly zero
//! where friction can hold it.

use hysteron_base::BadInput;

use crate::law::{Capstan, JointFriction, Sliding};
use crate::number::Real;

/// Friction of a joint against its speed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stribeck {
    /// Friction of steady slow motion, f_c [N m].
    pub coulomb: f64,
    /// Friction that must be overcome from standstill, f_s, not less than `coulomb` [N m].
    pub breakaway: f64,
    /// Speed over which the one becomes the other, v_s [rad/s].
    pub stribeck_velocity: f64,
    /// Viscous coefficient, f_v [N m s/rad].
    pub viscous: f64,
}

impl Stribeck {
    /// The law of Wan et al. (2026), eq. 3, with their exponent of 2.
    ///
    /// # Errors
    /// `BadInput` naming the number that cannot be.
    pub fn new(coulomb: f64, breakaway: f64, stribeck_velocity: f64, viscous: f64) -> Result<Self, BadInput> {
        let check = |name: &str, expected: &str, x: f64, holds: bool| match holds && x.is_finite() {
            true => Ok(()),
            false => Err(BadInput::new(name, expected, format!("{x:?}"))),
        };
        check("coulomb", "a finite number >= 0", coulomb, coulomb >= 0.0)?;
        check("breakaway", "at least the Coulomb friction", breakaway, breakaway >= coulomb)?;
        check("stribeck_velocity", "a finite number > 0", stribeck_velocity, stribeck_velocity > 0.0)?;
        check("viscous", "a finite number >= 0", viscous, viscous >= 0.0)?;
        Ok(Self { coulomb, breakaway, stribeck_velocity, viscous })
    }

    /// The parameters of [`crate::law::SymmetricStribeck`].
    pub fn parameters(&self) -> [f64; 4] {
        [self.coulomb, self.breakaway - self.coulomb, self.stribeck_velocity, self.viscous]
    }

    /// Size of the dry part at speed |v| [N m]: f_c + (f_s - f_c) exp(-(v/v_s)²).
    pub fn dry(&self, velocity: f64) -> f64 {
        let [coulomb, excess, at, _] = self.parameters();
        stribeck([coulomb, excess, at], velocity)
    }

    /// Torque that friction exerts against motion at `velocity` [rad/s], with its sign [N m]; 0 at standstill.
    ///
    /// # Reference
    /// Wan et al. (2026), eq. 3; the viscous term is outside the sign, as there (eq. 38 has it inside).
    pub fn torque(&self, velocity: f64) -> f64 {
        let sign = if velocity == 0.0 { 0.0 } else { velocity.signum() };
        self.dry(velocity) * sign + self.viscous * velocity
    }
}

/// Size of dry friction at `velocity`: f_c + Δ exp(-(v/v_s)²), from [f_c, Δ, v_s].
pub(crate) fn stribeck<T: Real>([coulomb, excess, at]: [T; 3], velocity: T) -> T {
    let x = velocity.abs() / at;
    let power = x * x;
    if power.value() > 40.0 {
        return coulomb; // the rest is below rounding
    }
    coulomb + excess * (-power).exp()
}

/// tanh(μθ/2): share of the sum of two tensions that a guide of wrap angle `wrap` [rad] can hold as difference [-].
///
/// It is the capstan equation T_hi = T_lo exp(μθ) solved for (T_hi - T_lo)/(T_hi + T_lo).
pub fn capstan_factor(friction: f64, wrap: f64) -> f64 {
    (0.5 * friction * wrap).tanh()
}

/// Largest difference of the tensions `a` and `b` [N] that a guide can hold [N]:
/// `constant` [N] + tanh(μθ/2) (a + b).
///
/// The law is [`Capstan`]'s, as of any joint: the tensions pull at both its sides.
pub fn capstan_bound(friction: f64, wrap: f64, constant: f64, a: f64, b: f64) -> f64 {
    let at = Sliding { velocity: 0.0, motor_torque: a, load_torque: -b };
    Capstan { wrap }.budget(&[friction, constant], &at).dry
}

#[cfg(test)]
#[allow(clippy::unwrap_used)] // a test may stop where it stands
mod tests {
    use super::*;

    fn law() -> Stribeck {
        Stribeck::new(6.17, 11.15, 0.5, 12.18).unwrap()
    }

    #[test]
    fn curve_falls_from_breakaway_to_coulomb_then_rises() {
        let law = law();
        assert!((law.torque(1e-9) - 11.15).abs() < 1e-6);
        assert!(law.torque(0.3) < 11.15 + 12.18 * 0.3);
        let fast = 20.0;
        assert!((law.torque(fast) - (6.17 + 12.18 * fast)).abs() < 1e-9);
        assert_eq!(law.torque(-0.4), -law.torque(0.4));
        assert_eq!(law.torque(0.0), 0.0);
    }

    #[test]
    fn capstan_bound_is_the_exponential_law() {
        let (mu, wrap, low) = (0.3, 1.7, 5.0);
        let high = low * f64::exp(mu * wrap);
        assert!((capstan_bound(mu, wrap, 0.0, high, low) - (high - low)).abs() < 1e-12 * high);
    }

    #[test]
    fn law_rejects_breakaway_below_coulomb() {
        assert_eq!(Stribeck::new(1.0, 0.5, 1.0, 0.0).unwrap_err().place, "breakaway");
        assert_eq!(Stribeck::new(-1.0, 0.5, 1.0, 0.0).unwrap_err().place, "coulomb");
        assert_eq!(Stribeck::new(1.0, 1.5, 0.0, 0.0).unwrap_err().place, "stribeck_velocity");
        assert_eq!(Stribeck::new(1.0, 1.5, 1.0, f64::NAN).unwrap_err().place, "viscous");
    }
}
