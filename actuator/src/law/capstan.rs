//! Friction of a rope around a guide, or of any joint whose friction is proportional to the sum of the
//! tensions at both its sides.

use super::{Budget, JointFriction, LawParameter, Sliding, number, torque};
use crate::number::Real;

/// constant + tanh(μθ/2) (T_a + T_b), with the two tensions as the motor's torque and the load's against it, in units of the
/// radius: the capstan equation T_a = T_b e^{μθ} where nothing is constant.
///
/// # Reference
/// Euler (1762), Remarques sur l'effet du frottement dans l'equilibre.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Capstan {
    /// Wrap angle θ [rad].
    pub wrap: f64,
}

impl JointFriction for Capstan {
    fn parameters(&self) -> Vec<LawParameter> {
        vec![number("friction_coefficient", 0.0, 2.0), torque("constant_n_m")]
    }

    fn budget<T: Real>(&self, p: &[T], at: &Sliding<T>) -> Budget<T> {
        let factor = (T::from(0.5 * self.wrap) * p[0]).tanh();
        Budget { dry: p[1] + factor * (at.motor_torque - at.load_torque).abs(), viscous: T::from(0.0) }
    }
}
